// plan.html of figure 1: opened from disk, looked at, measured, driven.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import {
  PICTURES, assertNear, closePage, drawn, middleOf, mrtamp, newFolder, openPage, pinhole, placedPoint, pointOf, readPicture, readTable,
  rowAt, seek, startBrowser,
} from "./support.mjs";

const MOMENTS = [0, 7.5, 25.2, 41.3, 1e9];
let [browser, file, plan, rows] = [];

before(async () => {
  const folder = newFolder();
  mrtamp(["plan", "figure1", "--in-process", "--out", folder]);
  mrtamp(["export", "csv", join(folder, "plan.json"), "--links", "--out", join(folder, "plan.csv")]);
  [file, plan, rows] = [join(folder, "plan.html"), JSON.parse(readFileSync(join(folder, "plan.json"))), readTable(join(folder, "plan.csv"))];
  browser = await startBrowser();
});
after(() => browser?.close());

const duringTransfer = () => {
  const [attach, detach] = ["attach", "detach"].map((kind) => plan.events.find((event) => event.kind === kind && event.pair === "r2.1").t);
  return (attach + detach) / 2;
};

/** Distinct colours of a picture, coarsely. */
const colours = (picture) => {
  const seen = new Set();
  for (let y = 0; y < picture.height; y += 3) for (let x = 0; x < picture.width; x += 3) seen.add(picture.at(x, y).map((c) => c >> 4).join());
  return seen.size;
};

for (const [width, height] of [[1280, 800], [390, 844]]) {
  for (const dark of [false, true]) {
    test(`at ${width} px, ${dark ? "dark" : "light"}, the page shows start, a transfer and the end, and nothing overflows`, async () => {
      const page = await openPage(browser, file, { width, height, dark, touch: width < 500 });
      const duration = await page.evaluate(() => window.mrtamp.duration);
      for (const [name, t] of [["start", 0], ["transfer", duringTransfer()], ["end", duration]]) {
        await seek(page, t);
        const path = join(PICTURES, `plan-${width}-${dark ? "dark" : "light"}-${name}.png`);
        const picture = readPicture(await page.screenshot({ path }));
        assert.ok(colours(picture) > 40, `${path} shows little`);
        assert.equal(picture.at(2, 2)[0] < 128, dark, "the header is dark when the page is");
        await assertTidy(page, width);
      }
      await page.screenshot({ path: join(PICTURES, `plan-${width}-${dark ? "dark" : "light"}-whole.png`), fullPage: true });
      await closePage(page);
    });
  }
}

/** No part of the page covers another or sticks out, and no name covers another. */
async function assertTidy(page, width) {
  const { scrollWidth, parts, names } = await page.evaluate(() => {
    const box = (element) => {
      const { left, top, right, bottom } = element.getBoundingClientRect();
      return { name: element.id || element.tagName + element.textContent, left, top, right, bottom };
    };
    const all = (selector) => [...document.querySelectorAll(selector)].filter((e) => e.offsetParent !== null || e.tagName === "HEADER").map(box);
    return { scrollWidth: document.documentElement.scrollWidth, parts: all("header, #stage, #controls, #panel, #timeline"), names: all(".label:not([hidden])") };
  });
  assert.ok(scrollWidth <= width, `the page is ${scrollWidth} px wide`);
  assert.equal(parts.length, 5);
  assert.ok(names.length >= 8, `only ${names.length} names are shown`);
  for (const list of [parts, names]) {
    for (const [i, a] of list.entries()) {
      for (const b of list.slice(i + 1)) {
        const apart = a.right <= b.left + 1 || b.right <= a.left + 1 || a.bottom <= b.top + 1 || b.bottom <= a.top + 1;
        assert.ok(apart, `${a.name} and ${b.name} overlap`);
      }
    }
  }
}

test("links and objects are on the page where the table's poses project to, within 3 px at five moments", async () => {
  const page = await openPage(browser, file);
  const links = Object.keys(rows[0]).map((name) => /^(\w+)\.link\.(\w+)\.x$/.exec(name)).filter(Boolean);
  assert.equal(links.length, 39, "three robots of thirteen links");
  for (const moment of MOMENTS) {
    const row = rowAt(rows, moment);
    await seek(page, row.t);
    const camera = await page.evaluate(() => window.mrtamp.camera());
    const named = [
      ...links.map(([, robot, link]) => [`link:${robot}/${link}`, `${robot}.link.${link}`]),
      ...["m1", "m2", "m3", "m4"].map((object) => [`object:${object}`, object]),
    ];
    const found = await page.evaluate((ids) => ids.map((id) => window.mrtamp.project(id)), named.map(([id]) => id));
    named.forEach(([id, column], i) => assertNear(found[i], pinhole(camera, pointOf(row, column)), 3, `${id} at ${row.t} s`));
  }
  await closePage(page);
});

test("what is painted of an object and of a hand lies where the table's poses project to, within 3 px at five moments", async () => {
  const page = await openPage(browser, file);
  // The middle of the hand's box in its frame, from the robot's description.
  const painted = [["object:m1", "m1", [0, 0, 0]], ["object:m4", "m4", [0, 0, 0]], ["link:r2/hand", "r2.link.hand", [0, 0, 0.035]]];
  for (const [view, moments] of [["fit", MOMENTS], ["top", MOMENTS.slice(1, 3)]]) {
    await page.evaluate((name) => window.mrtamp.look(name), view);
    for (const moment of moments) {
      const row = rowAt(rows, moment);
      await seek(page, row.t);
      const camera = await page.evaluate(() => window.mrtamp.camera());
      for (const [id, column, centre] of painted) {
        await page.evaluate((only) => window.mrtamp.only([only]), id);
        await drawn(page);
        const clip = { x: camera.left, y: camera.top + 40, width: camera.width, height: camera.height - 40 };
        const { count, x, y } = middleOf(readPicture(await page.screenshot({ clip })), ([r, g, b]) => r + g + b < 740);
        assert.ok(count > 8, `${id} is not painted at ${row.t} s`);
        assertNear([clip.x + x, clip.y + y], pinhole(camera, placedPoint(row, column, centre)), 3, `${id} at ${row.t} s, ${view}`);
      }
    }
  }
  await closePage(page);
});

/** Place of an element's middle on the page; on a curve between lanes that of the middle of the curve. */
const middle = (locator) => locator.evaluate((element) => {
  if (element.closest(".arcs, .orderings")) {
    const at = element.getPointAtLength(element.getTotalLength() / 2).matrixTransform(element.getScreenCTM());
    return [at.x, at.y];
  }
  const { left, right, top, bottom } = element.getBoundingClientRect();
  return [(left + right) / 2, (top + bottom) / 2];
});

async function hovered(page, locator) {
  await page.mouse.move(...(await middle(locator)));
  return page.locator("#tip").innerText();
}

test("the timeline names what the pointer is on: pairs, segments, events, orderings, arcs", async () => {
  const page = await openPage(browser, file);
  assert.match(await hovered(page, page.locator(".lane").nth(0).locator(".mode.transfer").first()), /r1\.1 transfer\s+brings m1 from w1 to w3/);
  assert.match(await hovered(page, page.locator(".lane").nth(1).locator(".hit").first()), /r2\.1 transit: the base drives/);
  assert.match(await hovered(page, page.locator(".lane").nth(0).locator(".grip.detach").first()), /detach m1\s+r1\.1, in w3/);
  assert.match(await hovered(page, page.locator(".lane").nth(2).locator(".waiting").first()), /waits/);
  assert.equal(await page.locator(".ordering.given").count(), plan.orderings.length);
  const words = [];
  for (let i = 0; i < plan.orderings.length; i++) words.push(await hovered(page, page.locator(".ordering .hit").nth(i)));
  for (const { before: first, after: later } of plan.orderings) {
    const sentence = `${first.point} of ${first.pair} before ${later.point} of ${later.pair}`;
    assert.ok(words.some((text) => text.includes(sentence)), `${sentence} in ${words}`);
  }
  assert.equal(await page.locator(".arcs .arc").count(), plan.dependencies.length);
  assert.ok((await page.locator(".arcs .binding").count()) > 0, "somebody waits for somebody");
  await page.locator("input[name=orderings]").uncheck();
  assert.equal(await page.locator(".orderings").isVisible(), false);
  assert.match(await hovered(page, page.locator(".arcs .binding .hit").first()), /may leave knot \d+ .* only once .* has reached knot \d+/);
  await page.mouse.move(4, 4);
  assert.equal(await page.locator("#tip").isVisible(), false);
  await closePage(page);
});

test("a click on the timeline goes to that time, and dragging scrubs", async () => {
  const page = await openPage(browser, file);
  for (const event of plan.events.filter(({ robot }) => robot === "r1").slice(0, 4)) {
    const index = plan.events.filter(({ robot }) => robot === "r1").indexOf(event);
    const [x, y] = await middle(page.locator(".lane").first().locator(".grip").nth(index));
    await page.mouse.click(x, y);
    const t = await page.evaluate(() => window.mrtamp.time());
    assert.ok(Math.abs(t - event.t) < 0.1, `${t} for ${event.t}`);
    await drawn(page);
    const head = await page.locator(".playhead line").boundingBox();
    assert.ok(Math.abs(head.x + head.width / 2 - x) < 2, "the playhead is under the pointer");
  }
  const box = await page.locator(".scroll svg").boundingBox();
  await page.mouse.move(box.x + 100, box.y + 10);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + 10, { steps: 4 });
  await page.mouse.up();
  const [t, duration] = await page.evaluate(() => [window.mrtamp.time(), window.mrtamp.duration]);
  assert.ok(Math.abs(t - duration / 2) < 0.2, `${t} of ${duration}`);
  await page.waitForFunction(() => location.hash === `#t=${window.mrtamp.time().toFixed(2)}`);
  await closePage(page);
});

test("keys play, step, jump and change the speed", async () => {
  const page = await openPage(browser, file, { hash: "#t=12.3" });
  const time = () => page.evaluate(() => window.mrtamp.time());
  const near = async (t) => assert.ok(Math.abs((await time()) - t) < 1e-3, `${await time()} for ${t}`);
  const press = (key) => page.keyboard.press(key);
  await near(12.3);
  await press("ArrowRight");
  await near(12.8);
  await press("Shift+ArrowLeft");
  await near(7.8);
  await press("Home");
  await near(0);
  await press(".");
  await near(plan.events[0].t);
  await press("End");
  await near(await page.evaluate(() => window.mrtamp.duration));
  await press("Home");
  await press("4");
  assert.equal(await page.evaluate(() => window.mrtamp.speed()), 4);
  await page.getByRole("button", { name: "8×" }).click();
  assert.equal(await page.evaluate(() => window.mrtamp.speed()), 8);
  await press("Space");
  await page.waitForFunction(() => window.mrtamp.playing() && window.mrtamp.time() > 2);
  await press("Space");
  assert.equal(await page.evaluate(() => window.mrtamp.playing()), false);
  const stopped = await time();
  await page.waitForTimeout(200);
  await near(stopped);
  await closePage(page);
});

test("playing ends at the end, and begins again from there", async () => {
  const page = await openPage(browser, file);
  await page.evaluate(() => window.mrtamp.seek(window.mrtamp.duration - 0.2));
  await page.locator("#play").click();
  await page.waitForFunction(() => !window.mrtamp.playing() && window.mrtamp.time() === window.mrtamp.duration);
  await page.locator("#play").click();
  await page.waitForFunction(() => window.mrtamp.playing() && window.mrtamp.time() < 10);
  await closePage(page);
});

const cameraOf = (page) => page.evaluate(() => window.mrtamp.camera());
const distance = ({ eye, target }) => Math.hypot(...eye.map((value, i) => value - target[i]));

test("the mouse turns, moves and zooms the picture, and R frames the scene again", async () => {
  const page = await openPage(browser, file);
  const first = await cameraOf(page);
  const drag = async (dx, dy) => {
    await page.mouse.move(400, 250);
    await page.mouse.down();
    await page.mouse.move(400 + dx, 250 + dy, { steps: 3 });
    await page.mouse.up();
  };
  await drag(120, 30);
  const turned = await cameraOf(page);
  assert.deepEqual(turned.target, first.target);
  assert.ok(Math.abs(distance(turned) - distance(first)) < 1e-6 && Math.abs(turned.eye[0] - first.eye[0]) > 1);
  await page.keyboard.down("Shift");
  await drag(80, 0);
  await page.keyboard.up("Shift");
  const moved = await cameraOf(page);
  assert.ok(Math.abs(moved.target[0] - turned.target[0]) > 0.1 || Math.abs(moved.target[1] - turned.target[1]) > 0.1);
  await page.mouse.wheel(0, -300);
  await page.waitForFunction((least) => {
    const { eye, target } = window.mrtamp.camera();
    return Math.hypot(...eye.map((value, i) => value - target[i])) < least;
  }, 0.8 * distance(moved));
  await page.keyboard.press("r");
  const again = await cameraOf(page);
  assert.ok(again.eye.every((value, i) => Math.abs(value - first.eye[i]) < 1e-6));
  await page.mouse.move(...(await page.evaluate(() => window.mrtamp.project("link:r3/base_link"))));
  await page.locator("#tip").waitFor();
  assert.match(await page.locator("#tip").innerText(), /^r3 (base_link|arm_\w+)\s+link at /);
  await closePage(page);
});

test("on a phone two fingers zoom the picture and a tap on the timeline goes there", async () => {
  const page = await openPage(browser, file, { width: 390, height: 844, touch: true });
  const first = await cameraOf(page);
  const session = await page.context().newCDPSession(page);
  const touch = (type, gap) => session.send("Input.dispatchTouchEvent", {
    type, touchPoints: type === "touchEnd" ? [] : [{ x: 195 - gap, y: 220, id: 1 }, { x: 195 + gap, y: 220, id: 2 }],
  });
  await touch("touchStart", 40);
  for (const gap of [60, 80, 100]) await touch("touchMove", gap);
  await touch("touchEnd", 0);
  await drawn(page);
  assert.ok(distance(await cameraOf(page)) < 0.6 * distance(first));
  const bar = page.locator(".lane").first().locator(".mode.transfer").first();
  await bar.tap();
  const [attach, detach] = ["attach", "detach"].map((kind) => plan.events.find((event) => event.kind === kind && event.pair === "r1.1").t);
  const t = await page.evaluate(() => window.mrtamp.time());
  assert.ok(t > attach && t < detach, `${t} within ${attach} to ${detach}`);
  await closePage(page);
});

test("the panel has the plan's figures, follows a robot, and the theme can be switched", async () => {
  const page = await openPage(browser, file);
  const text = await page.locator("#panel").innerText();
  const gap = (100 * (plan.makespan.task_s - plan.lower_bound.seconds)) / plan.lower_bound.seconds;
  const figures = [`${plan.makespan.task_s.toFixed(2)} s`, `${plan.lower_bound.seconds.toFixed(2)} s`, `${gap.toFixed(1)} %`, "4 given", "0 discovered", String(plan.dependencies.length)];
  for (const figure of figures) assert.ok(text.includes(figure), `${figure} in ${text}`);
  for (const stage of ["placement", "transition", "roadmap", "composite"]) assert.ok(text.includes(stage), stage);
  await seek(page, duringTransfer());
  assert.match(await page.locator(".robot-row").nth(1).innerText(), /transfer m1/);
  await page.locator(".robot-row").nth(1).click();
  await drawn(page);
  const base = pointOf(rowAt(rows, duringTransfer()), "r2.link.base_link");
  assert.ok(Math.hypot(...(await cameraOf(page)).target.slice(0, 2).map((value, i) => value - base[i])) < 0.2);
  await page.locator("#theme").click();
  assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), "dark");
  await page.screenshot({ path: join(PICTURES, "plan-1280-dark-followed.png") });
  await page.keyboard.press("?");
  assert.ok(await page.locator("#keys").isVisible());
  await page.keyboard.press("Escape");
  await closePage(page);
});
