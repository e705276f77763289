// failure.html, a page with a discovered ordering, a page that is refused, and the glTF.

import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import validator from "gltf-validator";
import { PICTURES, closePage, drawn, middleOf, mrtamp, newFolder, openPage, ownFile, readPicture, seek, startBrowser } from "./support.mjs";

let browser;
before(async () => (browser = await startBrowser()));
after(() => browser?.close());

/** Vermilion, lit, in shade or over white. */
const isCulprit = ([r, g, b]) => r > g + 35 && g > b + 5 && r > b + 60;

test("a failure's page shows the culprits, what was tried and the causes with their counts", async () => {
  const folder = newFolder();
  mrtamp(["plan", ownFile("out_of_reach.yaml"), "--in-process", "--out", folder], 3);
  assert.ok(!existsSync(join(folder, "plan.html")));
  const failure = JSON.parse(readFileSync(join(folder, "failure.json")));
  for (const [width, height, dark] of [[1280, 800, false], [1280, 800, true], [390, 844, false]]) {
    const page = await openPage(browser, join(folder, "failure.html"), { width, height, dark });
    const path = join(PICTURES, `failure-${width}-${dark ? "dark" : "light"}.png`);
    readPicture(await page.screenshot({ path }));
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), true);
    assert.match(await page.locator(".verdict").innerText(), /There is no plan: proven/);
    assert.match(await page.locator(".proof .cause").innerText(), /^r1 cannot reach far to place in r1\.1: the hand would have to be 2\.\d+ m or more/);
    assert.equal(await page.locator(".cause").count(), failure.causes.length + 1);
    const [, count] = failure.causes.find(([cause]) => cause.unreachable);
    assert.match(await page.locator(".task .cause").first().innerText(), new RegExp(`^${count} ×\\s+r1 cannot reach m1 in far`));
    const blamed = await page.locator(".label.blamed:not([hidden])").allInnerTexts();
    assert.deepEqual(blamed.sort(), ["! far", "! m1", "! r1"]);
    const panel = await page.locator("#panel").innerText();
    assert.match(panel, /As much as the proof needed/);
    for (const { stage, jobs } of failure.stages) assert.match(panel, new RegExp(`${stage}\\s+${jobs}`));
    await closePage(page);
  }
});

test("the bodies that the chosen cause names are painted as culprits, others are not", async () => {
  const folder = newFolder();
  mrtamp(["plan", ownFile("out_of_reach.yaml"), "--in-process", "--out", folder], 3);
  const page = await openPage(browser, join(folder, "failure.html"));
  await page.keyboard.press("l");
  const share = async (ids) => {
    await page.evaluate((only) => window.mrtamp.only(only), ids);
    await drawn(page);
    const { left, top, width, height } = await page.evaluate(() => window.mrtamp.camera());
    const picture = readPicture(await page.screenshot({ clip: { x: left, y: top + 40, width, height: height - 40 } }));
    return middleOf(picture, isCulprit).count / middleOf(picture, ([r, g, b]) => r + g + b < 740).count;
  };
  for (const id of ["object:m1", "link:r1/arm_4", "region:far", "fixed:far_table"]) assert.ok((await share([id])) > 0.5, id);
  for (const id of ["object:bystander", "region:near"]) assert.equal(await share([id]), 0, id);
  await page.evaluate(() => window.mrtamp.only(undefined));
  await page.locator(".cause").first().click();
  await drawn(page);
  assert.equal(await page.locator(".cause").first().getAttribute("aria-pressed"), "false");
  await closePage(page);
});

test("a discovered ordering is drawn apart from given ones and says why it is there", async () => {
  const folder = newFolder();
  mrtamp(["plan", "t05_tiny_region", "--in-process", "--out", folder]);
  const page = await openPage(browser, join(folder, "plan.html"));
  assert.equal(await page.locator(".ordering.discovered").count(), 1);
  assert.match(await page.locator(".orderings-list").innerText(), /discovered\s*grasp of r2\.1 before release of r1\.1: new fits into tiny only once old has left/i);
  const plan = JSON.parse(readFileSync(join(folder, "plan.json")));
  const { t } = plan.events.find((event) => event.kind === "attach" && event.pair === "r2.1");
  await page.locator(".orderings-list button").click();
  assert.ok(Math.abs((await page.evaluate(() => window.mrtamp.time())) - t) < 1e-3);
  await seek(page, t);
  await page.screenshot({ path: join(PICTURES, "plan-1280-light-discovered.png") });
  await closePage(page);
});

test("the page of a plan that the checker refuses says so and why", async () => {
  const folder = newFolder();
  mrtamp(["plan", "t00_one_arm", "--in-process", "--out", folder]);
  const plan = JSON.parse(readFileSync(join(folder, "plan.json")));
  for (const knot of plan.robots[0].knots) knot.t /= 10;
  for (const event of plan.events) event.t /= 10;
  const file = join(folder, "hasty.json");
  writeFileSync(file, JSON.stringify(plan));
  assert.equal(mrtamp(["view", file]).trim(), join(folder, "hasty.html"));
  const page = await openPage(browser, join(folder, "hasty.html"));
  assert.equal(await page.locator(".verdict").innerText(), "refused by the checker");
  assert.match(await page.locator("#panel").innerText(), /what the checker found\s+V\d+/i);
  await closePage(page);
});

for (const scene of ["figure1", "t05_tiny_region", "t00_one_arm"]) {
  test(`the glTF of ${scene} is valid: no error, no warning`, async () => {
    const folder = newFolder();
    mrtamp(["plan", scene, "--in-process", "--out", folder]);
    const file = mrtamp(["export", "glb", join(folder, "plan.json")]).trim();
    const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 20 });
    const bad = report.issues.messages.filter((message) => message.severity < 2);
    assert.deepEqual(bad, []);
    assert.equal(report.issues.numErrors + report.issues.numWarnings, 0);
    assert.equal(report.info.animationCount, 1);
    assert.ok(report.info.totalTriangleCount > 1000);
  });
}
