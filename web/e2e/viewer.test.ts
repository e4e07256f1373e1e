import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { createServer, get, type Server } from 'node:http';
import type { AddressInfo } from 'node:net';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { random } from '../src/testing/random.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import { isFirefox } from './browsers.ts';
import { complaints, type Home, inspect, keepScreenshot, missing, openHome, openPage, patience, program, scan } from './harness.ts';

declare const window: { enfilade?: { viewer: Viewer } };

const ready = (page: Page) => page.waitForFunction(() => window.enfilade !== undefined);
const pose = (page: Page) => page.evaluate(() => window.enfilade!.viewer.pose);

/** At the floor of the first place that one can go to, which is in the middle of the view then. */
const lookAtNeighbour = (page: Page): Promise<void> =>
  page.evaluate(() => {
    const { viewer } = window.enfilade!;
    const { viewpoint } = viewer.pose;
    const to = viewer.scan.viewpoints[viewer.scan.viewpoints[viewpoint]!.neighbours[0]!]!;
    const [dx, dy] = [0, 1].map((k) => to.position[k]! - viewer.scan.viewpoints[viewpoint]!.position[k]!);
    viewer.look(Math.atan2(dx!, dy!), -Math.atan2(1.5, Math.hypot(dx!, dy!)));
  });

describe.skipIf(missing)('the viewer', () => {
  let home: Home;
  let page: Page;

  beforeAll(async () => {
    home = await openHome();
    page = await openPage(home, `/view#${scan}`);
    await ready(page);
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('shows what the CPU renderer draws, at 20 poses', async () => {
    const next = random(1);
    const count = await page.evaluate(() => window.enfilade!.viewer.scan.viewpoints.length);
    const file = join(home.folder, 'view.png');
    const [width, height] = [512, 384];
    const found: number[] = [];
    for (let k = 0; k < 20; ++k) {
      const viewpoint = Math.floor(next() * count);
      const [heading, elevation] = [next() * 360, next() * 120 - 60];
      const vfov = 40 + next() * 50;
      execFileSync(program, ['render', scan, String(viewpoint), '--data', home.folder,
        '--heading', String(heading), '--elevation', String(elevation), '--vfov', String(vfov),
        '--size', `${width}x${height}`, '-o', file]);
      found.push(await page.evaluate(psnr, {
        picture: readFileSync(file).toString('base64'), width, height,
        pose: { viewpoint, heading: (heading * Math.PI) / 180, elevation: (elevation * Math.PI) / 180,
          vfov: (vfov * Math.PI) / 180 },
      }));
    }
    console.log(`PSNR over 20 poses: least ${Math.min(...found).toFixed(1)} dB`);
    // 8 bits rounded twice are above 50 dB; a face turned, mirrored or a pixel off is below 30.
    expect(Math.min(...found)).toBeGreaterThan(30);
  });

  it('is looked around in and walked by keys', async () => {
    await page.goto(`${home.server}/view#${scan}`);
    await page.reload();
    await ready(page);
    await page.locator('canvas').focus();
    const before = await pose(page);
    await page.keyboard.press('ArrowRight');
    expect((await pose(page)).heading).toBeCloseTo((before.heading + Math.PI / 18) % (2 * Math.PI), 5);
    await page.keyboard.press('ArrowUp');
    expect((await pose(page)).elevation).toBeGreaterThan(before.elevation);
    await page.keyboard.press('+');
    expect((await pose(page)).vfov).toBeLessThan(before.vfov);
    await page.keyboard.press('Enter');
    await page.waitForFunction((v) => window.enfilade!.viewer.pose.viewpoint !== v, before.viewpoint);
  });

  it('is dragged, and gone through by clicks on discs', async () => {
    await page.evaluate(() => window.enfilade!.viewer.jump({ elevation: -0.2, vfov: 1.5 }));
    const box = (await page.locator('canvas').boundingBox())!;
    const before = await pose(page);
    await page.mouse.move(box.x + 300, box.y + 300);
    await page.mouse.down();
    await page.mouse.move(box.x + 200, box.y + 300, { steps: 5 });
    await page.mouse.up();
    const after = await pose(page);
    expect(after.viewpoint).toBe(before.viewpoint);
    expect(Math.sin(after.heading - before.heading)).toBeGreaterThan(0); // leftwards: to the right
    await lookAtNeighbour(page);
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await page.waitForFunction((v) => window.enfilade!.viewer.pose.viewpoint !== v, before.viewpoint);
  });

  it('says where it is in its address, and goes where the address says', async () => {
    const id = await page.evaluate(() => window.enfilade!.viewer.scan.viewpoints[3]!.id);
    await page.evaluate((to) => { location.hash = `#home0001/${to}/90/-10`; }, id);
    await page.waitForFunction(() => window.enfilade!.viewer.pose.viewpoint === 3);
    expect((await pose(page)).heading).toBeCloseTo(Math.PI / 2);
    await page.evaluate(() => { window.enfilade!.viewer.look(Math.PI, 0); });
    await page.waitForFunction((to) => location.hash === `#home0001/${to}/180/0`, id);
  });

  it('stands where it was sent last, whichever pictures come first', async () => {
    const one = await openPage(home, `/view#${scan}`);
    await ready(one);
    await one.waitForLoadState('networkidle');
    const { late, id } = await one.evaluate(() => { // its pictures are not there yet
      const { scan: { viewpoints }, pose: { viewpoint } } = window.enfilade!.viewer;
      const kept = [viewpoint, ...viewpoints[viewpoint]!.neighbours];
      const found = viewpoints.findIndex(({ rotation }, v) => rotation && !kept.includes(v));
      return { late: found, id: viewpoints[found]!.id };
    });
    await one.route(`**/viewpoints/${id}/**`, async (route) => {
      await new Promise((resolve) => setTimeout(resolve, 300));
      await route.continue();
    });
    const { viewpoint: last } = await pose(one);
    await one.evaluate(async ([first, second]) => {
      const { viewer } = window.enfilade!;
      await Promise.all([viewer.jump({ viewpoint: first!, heading: 0 }), viewer.jump({ viewpoint: second!, heading: 0 })]);
    }, [late, last]);
    expect((await pose(one)).viewpoint).toBe(last);
    await one.close();
  });

  it('flies through an episode, and shows its instruction as text', async () => {
    await page.goto(`${home.server}/view?split=val_seen&id=1_1`);
    await ready(page);
    expect(await page.locator('.instruction').textContent()).toContain('<img src=x');
    expect(await page.locator('.instruction img').count()).toBe(0);
    const { viewpoint: start, heading } = await pose(page);
    expect(heading, 'it looks where the path goes').toBeCloseTo(await page.evaluate((from) => {
      const { scan: { viewpoints }, nextOnPath } = window.enfilade!.viewer;
      const [dx, dy] = [0, 1].map((k) => viewpoints[nextOnPath!]!.position[k]! - viewpoints[from]!.position[k]!);
      return (Math.atan2(dx!, dy!) + 2 * Math.PI) % (2 * Math.PI);
    }, start), 5);
    await expectPointer(page, undefined);
    await page.evaluate((to) => window.enfilade!.viewer.look(to, 0), heading + 2);
    await expectPointer(page, 'left'); // one looks too far to the right
    await page.evaluate((to) => window.enfilade!.viewer.look(to, 0), heading);
    await inspect(page, 'view-episode');
    await page.getByLabel('Speed').selectOption('4');
    await page.getByRole('button', { name: 'Play' }).click();
    await page.getByRole('button', { name: 'Replay' }).waitFor();
    expect((await pose(page)).viewpoint).not.toBe(start);
  });

  it('lays depth and classes over the colours', async () => {
    const sum = () => page.evaluate(() =>
      window.enfilade!.viewer.capture(32, 32).reduce((total, x) => total + x, 0));
    const plain = await sum();
    await page.getByRole('combobox', { name: 'Layer' }).selectOption('depth');
    await page.waitForFunction((before) =>
      window.enfilade!.viewer.capture(32, 32).reduce((total, x) => total + x, 0) !== before, plain);
    await page.getByText('Distance from the eye').waitFor();
    await inspect(page, 'view-depth');
    await page.getByRole('combobox', { name: 'Layer' }).selectOption('class');
    await page.getByRole('region', { name: 'Legend' }).getByText('wall', { exact: true }).waitFor();
    await inspect(page, 'view-classes');
    await page.getByRole('combobox', { name: 'Layer' }).selectOption('colour');
    await page.waitForFunction((before) =>
      window.enfilade!.viewer.capture(32, 32).reduce((total, x) => total + x, 0) === before, plain);
  });

  it('glides through the room that the two panoramas show', async () => {
    const like = await page.evaluate(likeness);
    console.log(`relief against panorama: ${like.begin.toFixed(1)} dB at the begin, ${like.end.toFixed(1)} dB at the end of a glide`);
    // Seen from its own eye a relief is the panorama, whatever the distances are.
    expect(like.begin).toBeGreaterThan(30);
    expect(like.end).toBeGreaterThan(30);
    expect(like.middle, 'half way is a view of its own').toBeLessThan(30);
    await page.reload(); // it was confined
    await ready(page);
    await page.setViewportSize({ width: 1280 + 352, height: 720 + 46 }); // panel and header: the picture has 1280 x 720
    const { frames, seconds } = await page.evaluate(countFrames);
    await page.setViewportSize({ width: 1280, height: 800 });
    console.log(`a glide at 1280 x 720: ${(frames / seconds).toFixed(0)} frames a second`);
    expect(frames).toBeGreaterThan(2); // docs/web.md has the measured figure
  });

  // WebDriver BiDi cannot ask for less motion.
  it.skipIf(isFirefox)('only changes the pictures for those who want less motion', async () => {
    await page.emulateMedia({ reducedMotion: 'reduce' });
    const { frames, seconds } = await page.evaluate(countFrames);
    expect(frames).toBeGreaterThan(0);
    expect(seconds).toBeLessThan(10);
    await page.emulateMedia({ reducedMotion: 'no-preference' });
  });

  it('has a map with rooms, on which a click goes there', async () => {
    await page.goto(`${home.server}/view#${scan}`);
    await page.reload();
    await ready(page);
    await page.locator('.enfilade-map .rooms polygon').first().waitFor();
    expect(await page.locator('.enfilade-map .walls').getAttribute('d')).toMatch(/^M-?[\d.]+ /);
    await page.locator('.enfilade-map .scale text').getByText(/^\d+ m$/).waitFor();
    const before = (await pose(page)).viewpoint;
    const dots = page.locator('.enfilade-map .dots circle');
    await dots.nth((before + 5) % await dots.count()).click();
    await page.waitForFunction((v) => window.enfilade!.viewer.pose.viewpoint !== v, before);
    await inspect(page, 'view');
  });

  it('goes to a room by its name, and says where it is', async () => {
    const rooms = page.getByRole('combobox', { name: 'Go to a room' });
    const room = (await rooms.locator('option').allTextContents()).at(-1)!;
    await rooms.selectOption(room);
    const there = new RegExp(`^${room.split(',')[0]!}`, 'i');
    await page.locator('.view-place').getByText(there).waitFor();
  });

  it("shows the building as a doll's house, and goes into it", async () => {
    await page.getByRole('button', { name: 'Doll’s house' }).click();
    const house = page.locator('.enfilade-house canvas');
    await house.waitFor();
    await inspect(page, 'view-house');
    await house.focus();
    await page.keyboard.press('ArrowRight');
    const box = (await house.boundingBox())!;
    const hint = page.locator('.enfilade-house .enfilade-hint');
    // Some point of the picture is a floor: look for one that names its room.
    for (let k = 0; k < 49 && (await hint.isHidden()); ++k) {
      await page.mouse.move(box.x + (box.width * (1 + (k % 7))) / 8, box.y + (box.height * (1 + Math.floor(k / 7))) / 8);
    }
    const room = await hint.textContent();
    await page.mouse.down();
    await page.mouse.up();
    await page.locator('.view-place').getByText(new RegExp(`^${room}`, 'i')).waitFor();
    await page.getByRole('button', { name: 'Plan' }).click();
    await page.locator('.enfilade-map').waitFor();
  });

  it('shares the link of what one sees', async () => {
    // WebDriver BiDi cannot grant it: in Firefox the link is pasted, as people do.
    if (!isFirefox) await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    await page.evaluate(() => window.enfilade!.viewer.look(1, -0.1));
    await page.getByRole('button', { name: 'Share' }).click();
    await page.getByText('Link copied').waitFor();
    const link = isFirefox ? await pasted(page) : await page.evaluate(() => navigator.clipboard.readText());
    expect(link).toMatch(/^http.*\/view#home0001\/[^/]+\/57\.3\/-5\.7$/);
  });

  it('says where a click would go', async () => {
    await lookAtNeighbour(page);
    const box = (await page.locator('.enfilade-canvas').boundingBox())!;
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.locator('.view > .enfilade-hint').getByText(/\d\.\d m$/).waitFor();
  });

  it('shows its first panorama soon', async () => {
    const fresh = await openPage(home, `/view#${scan}`);
    await ready(fresh);
    const soon = await fresh.evaluate(() => performance.getEntriesByName('enfilade-first-panorama')[0]!.startTime);
    console.log(`first panorama after ${soon.toFixed(0)} ms`);
    expect(soon).toBeLessThan(10_000); // a busy machine's; docs/web.md has the measured figure
    await fresh.close();
  });

  it('is embedded by another page, behind the same proxy', async () => {
    const proxy = await proxyWith(home.server, '/embed.html', join(import.meta.dirname, '../../examples/web/embed.html'));
    const other = await home.browser.newPage();
    other.setDefaultTimeout(patience);
    await other.goto(`http://127.0.0.1:${(proxy.address() as AddressInfo).port}/embed.html`);
    await other.locator('#here canvas').waitFor();
    await other.getByRole('navigation', { name: 'Places to go to' }).getByRole('button').first().focus();
    await other.keyboard.press('Enter');
    await other.getByText(/^Viewpoint [1-9]/).waitFor({ state: 'attached' });
    await keepScreenshot(other, 'embed');
    await other.close();
    await new Promise((resolve) => proxy.close(resolve));
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});

/** At which side of the picture an arrow shows where the path goes on; nowhere: no arrow. */
async function expectPointer(page: Page, side: 'left' | 'right' | undefined): Promise<void> {
  const pointer = page.locator('.enfilade-next');
  expect(await pointer.isVisible()).toBe(side !== undefined);
  if (side) expect(await pointer.getAttribute('data-side')).toBe(side);
}

/** What Control and V put into a field. */
async function pasted(page: Page): Promise<string> {
  await page.evaluate(() => document.body.append(Object.assign(document.createElement('textarea'), { id: 'pasted' })));
  const field = page.locator('#pasted');
  await field.focus();
  await page.keyboard.press('Control+V');
  const text = await field.inputValue();
  await field.evaluate((element) => element.remove());
  return text;
}

/** Runs in the page: how many frames a glide to a neighbour has, and how long it takes. */
async function countFrames(): Promise<{ frames: number; seconds: number }> {
  const { viewer } = window.enfilade!;
  let [frames, on] = [0, true];
  const count = () => {
    ++frames;
    if (on) requestAnimationFrame(count);
  };
  const to = viewer.scan.viewpoints[viewer.pose.viewpoint]!.neighbours[0]!;
  await viewer.jump({}); // its neighbours are being fetched now
  await new Promise((resolve) => setTimeout(resolve, 2000));
  const begin = performance.now();
  requestAnimationFrame(count);
  await viewer.go(to);
  on = false;
  return { frames, seconds: (performance.now() - begin) / 1000 };
}

/** Runs in the page: the begin, the middle and the end of a glide against the two panoramas, dB. */
async function likeness(): Promise<{ begin: number; middle: number; end: number }> {
  const { viewer } = window.enfilade!;
  const canvas = document.querySelector<HTMLCanvasElement>('.enfilade-canvas')!;
  const [width, height] = [320, 200];
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true })!;
  viewer.setMarks(new Map());
  viewer.confine([]); // no discs
  const from = viewer.scan.viewpoints.findIndex(({ rotation, neighbours }) => rotation && neighbours.length > 0);
  const to = viewer.scan.viewpoints[from]!.neighbours[0]!;
  const look = { heading: 1, elevation: -0.1 };
  const seen = async (moment: { from: number; to: number; share: number }) => {
    await viewer.showMoment({ ...moment, ...look });
    // After the frame that draws it, before the browser takes the picture away.
    await new Promise<void>((resolve) => requestAnimationFrame(() => {
      context.drawImage(canvas, 0, 0, width, height);
      resolve();
    }));
    return context.getImageData(0, 0, width, height).data;
  };
  const decibel = (a: Uint8ClampedArray, b: Uint8ClampedArray) => {
    const squares = a.reduce((sum, value, k) => sum + (value - b[k]!) ** 2, 0);
    return 10 * Math.log10(255 ** 2 / Math.max(squares / a.length, 1e-10));
  };
  const end = await seen({ from: to, to, share: 0 });
  const begin = await seen({ from, to: from, share: 0 });
  const moved = await seen({ from, to, share: 1e-6 });
  const middle = await seen({ from, to, share: 0.5 });
  const arrived = await seen({ from, to, share: 1 - 1e-6 });
  await viewer.jump({ viewpoint: from });
  return { begin: decibel(begin, moved), middle: Math.max(decibel(begin, middle), decibel(end, middle)), end: decibel(end, arrived) };
}

/** What nginx would do: one file of its own, all else from the server. */
async function proxyWith(server: string, path: string, file: string): Promise<Server> {
  const proxy = createServer((request, response) => {
    if (request.url === path) {
      response.setHeader('Content-Type', 'text/html');
      response.end(readFileSync(file));
      return;
    }
    const onward = get(server + request.url!, (answer) => {
      response.writeHead(answer.statusCode!, answer.headers);
      answer.pipe(response);
    });
    onward.on('error', () => response.destroy());
  });
  await new Promise<void>((resolve) => proxy.listen(0, '127.0.0.1', resolve));
  return proxy;
}

interface Question {
  readonly picture: string;
  readonly width: number;
  readonly height: number;
  readonly pose: { viewpoint: number; heading: number; elevation: number; vfov: number };
}

/** Runs in the page: the peak signal-to-noise ratio of the viewer against a PNG, in dB. */
async function psnr({ picture, width, height, pose: wanted }: Question): Promise<number> {
  const bytes = Uint8Array.from(atob(picture), (c) => c.charCodeAt(0));
  const bitmap = await createImageBitmap(new Blob([bytes]), { colorSpaceConversion: 'none' });
  const context = new OffscreenCanvas(width, height).getContext('2d')!;
  context.drawImage(bitmap, 0, 0);
  const expected = context.getImageData(0, 0, width, height).data;
  await window.enfilade!.viewer.jump(wanted);
  const got = window.enfilade!.viewer.capture(width, height);
  let squares = 0;
  for (let k = 0; k < expected.length; ++k) {
    if (k % 4 !== 3) squares += (expected[k]! - got[k]!) ** 2;
  }
  return 10 * Math.log10(255 ** 2 / Math.max(squares / (width * height * 3), 1e-10));
}
