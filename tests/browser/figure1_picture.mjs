// Takes the picture of the README: figure 1 in the middle of its plan. `npm run picture` writes launch/view/figure1.png.

import assert from "node:assert/strict";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { closePage, mrtamp, newFolder, openPage, ownFile, seek, startBrowser } from "./support.mjs";

const PICTURE = process.env.PICTURE || ownFile("../../launch/view/figure1.png");
const MOST_BYTES = 300_000;

const folder = newFolder();
mrtamp(["plan", "figure1", "--in-process", "--out", folder]);
const plan = JSON.parse(readFileSync(join(folder, "plan.json")));

/** Robots that hold something at a time. */
const holding = (t) => {
  const holders = new Map();
  for (const event of plan.events.filter((event) => event.t <= t)) holders.set(event.object, event.kind === "attach" ? event.robot : undefined);
  return [...holders.values()].filter(Boolean).length;
};
const middle = plan.makespan.task_s / 2;
const moments = Array.from({ length: 200 }, (_, i) => (plan.makespan.task_s * (i + 1)) / 202);
// As many full hands as there are at any moment, as near to the middle as may be.
moments.sort((a, b) => holding(b) - holding(a) || Math.abs(a - middle) - Math.abs(b - middle));

const browser = await startBrowser();
const page = await openPage(browser, join(folder, "plan.html"), { width: 1060, height: 720 });
await seek(page, moments[0]);
writeFileSync(PICTURE, await page.screenshot());
await closePage(page);
await browser.close();
const { size } = statSync(PICTURE);
assert.ok(size < MOST_BYTES, `${PICTURE} has ${size} bytes`);
console.log(`${PICTURE}: t = ${moments[0].toFixed(2)} s, ${size} bytes`);
