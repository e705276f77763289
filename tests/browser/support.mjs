// Running the program and the browser, reading tables and pictures, and a projection of our own.

import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { inflateSync } from "node:zlib";
import { chromium } from "playwright-core";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const PROGRAM = process.env.MRTAMP || join(ROOT, "target/release/mrtamp");
const BROWSERS = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/** Folder for screenshots; kept. */
export const PICTURES = process.env.PICTURES || join(ROOT, "target/tmp/browser");
mkdirSync(PICTURES, { recursive: true });

export const newFolder = () => mkdtempSync(join(tmpdir(), "mrtamp-browser-"));
export const ownFile = (name) => fileURLToPath(new URL(name, import.meta.url));

/** Runs the program; its exit code must be `code`. */
export function mrtamp(parameters, code = 0) {
  const ended = spawnSync(PROGRAM, parameters, { encoding: "utf8" });
  assert.equal(ended.status, code, `${PROGRAM} ${parameters.join(" ")}: ${ended.error ?? ""} ${ended.stderr}`);
  return ended.stdout;
}

/** Starts the browser; that there is none is a failure. */
export async function startBrowser() {
  const executablePath = BROWSERS.find((path) => path && existsSync(path));
  assert.ok(executablePath, `no browser at any of ${BROWSERS.filter(Boolean).join(", ")}`);
  execFileSync(executablePath, ["--version"], { stdio: "ignore" });
  return chromium.launch({
    executablePath,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
}

/**
 * Opens a page from disk and waits for its first picture. `page.complaints` collects every request for anything but the
 * page itself, every error and every word on the console.
 */
export async function openPage(browser, file, { width = 1280, height = 800, dark = false, touch = false, hash = "" } = {}) {
  const context = await browser.newContext({
    viewport: { width, height }, colorScheme: dark ? "dark" : "light", hasTouch: touch, isMobile: touch, offline: true,
  });
  const page = await context.newPage();
  const address = pathToFileURL(file).href;
  page.complaints = [];
  page.on("request", (request) => {
    const url = request.url();
    if (url.split("#")[0] !== address && !url.startsWith("data:")) page.complaints.push(`request for ${url}`);
  });
  page.on("console", (message) => page.complaints.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => page.complaints.push(`error: ${error.message}`));
  await page.goto(address + hash);
  await page.waitForFunction(() => window.mrtamp?.ready, undefined, { timeout: 30_000 });
  return page;
}

/** Closes a page that had nothing to complain about. */
export async function closePage(page) {
  assert.deepEqual(page.complaints, []);
  await page.context().close();
}

/** Waits until what was asked for has been drawn. */
export const drawn = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

export async function seek(page, t) {
  await page.evaluate((time) => window.mrtamp.seek(time), t);
  await drawn(page);
}

/** Rows of a table as objects; empty fields and names stay text. */
export function readTable(file) {
  const [head, ...lines] = readFileSync(file, "utf8").trimEnd().split("\r\n").map((line) => line.split(","));
  return lines.map((fields) => Object.fromEntries(head.map((name, i) => [name, name.endsWith(".holder") ? fields[i] : Number(fields[i])])));
}

/** The row of a table nearest to a time. */
export const rowAt = (rows, t) => rows.reduce((best, row) => (Math.abs(row.t - t) < Math.abs(best.t - t) ? row : best));

export const pointOf = (row, name) => ["x", "y", "z"].map((axis) => row[`${name}.${axis}`]);

/** A point of a body's frame in the world, from the body's pose in a row. */
export function placedPoint(row, name, [px, py, pz]) {
  const [x, y, z, w] = ["qx", "qy", "qz", "qw"].map((part) => row[`${name}.${part}`]);
  const rotation = [
    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
  ];
  const origin = pointOf(row, name);
  return rotation.map((line, i) => origin[i] + line[0] * px + line[1] * py + line[2] * pz);
}

/** A pinhole camera: where a world point is on the page (px). */
export function pinhole(camera, point) {
  const minus = (a, b) => a.map((value, i) => value - b[i]);
  const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((value) => value / Math.hypot(...a));
  const forward = unit(minus(camera.target, camera.eye));
  const right = unit(cross(forward, camera.up));
  const down = cross(forward, right);
  const ray = minus(point, camera.eye);
  const focal = camera.height / 2 / Math.tan(camera.fovY / 2);
  const [x, y] = [right, down].map((axis) => (focal * dot(ray, axis)) / dot(ray, forward));
  return [camera.left + camera.width / 2 + x, camera.top + camera.height / 2 + y];
}

/** Pixels of a PNG with 8 bits per component, as the browser writes them. */
export function readPicture(png) {
  const width = png.readUInt32BE(16);
  const height = png.readUInt32BE(20);
  assert.equal(png[24], 8);
  const channels = { 2: 3, 6: 4 }[png[25]];
  const packed = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") packed.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
  }
  const raw = inflateSync(Buffer.concat(packed));
  const stride = width * channels;
  const data = Buffer.alloc(stride * height);
  for (let y = 0; y < height; y++) unfilter(raw, y, stride, channels, data);
  return { width, height, at: (x, y) => [0, 1, 2].map((i) => data[y * stride + x * channels + i]) };
}

function unfilter(raw, y, stride, channels, data) {
  const filter = raw[y * (stride + 1)];
  for (let i = 0; i < stride; i++) {
    const left = i >= channels ? data[y * stride + i - channels] : 0;
    const up = y ? data[(y - 1) * stride + i] : 0;
    const corner = y && i >= channels ? data[(y - 1) * stride + i - channels] : 0;
    const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
    data[y * stride + i] = raw[y * (stride + 1) + 1 + i] + guess;
  }
}

function paeth(a, b, c) {
  const [da, db, dc] = [a, b, c].map((value) => Math.abs(a + b - c - value));
  if (da <= db && da <= dc) return a;
  return db <= dc ? b : c;
}

/** Middle of the pixels of a picture for which `wanted` holds, and their number. */
export function middleOf(picture, wanted) {
  let [count, sumX, sumY] = [0, 0, 0];
  for (let y = 0; y < picture.height; y++) {
    for (let x = 0; x < picture.width; x++) {
      if (wanted(picture.at(x, y))) [count, sumX, sumY] = [count + 1, sumX + x + 0.5, sumY + y + 0.5];
    }
  }
  return { count, x: sumX / count, y: sumY / count };
}

export function assertNear(found, exact, within, what) {
  const apart = Math.hypot(found[0] - exact[0], found[1] - exact[1]);
  assert.ok(apart <= within, `${what}: ${apart.toFixed(2)} px apart: (${found}) for (${exact})`);
  return apart;
}
