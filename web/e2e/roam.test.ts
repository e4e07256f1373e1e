/** Continuous walking: the browser's steps end where the simulator's do, and what it shows is a building. */
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { gunzipSync } from 'node:zlib';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Vec3 } from '../src/geometry/geometry.ts';
import { Floor, type FloorData } from '../src/roam/floor.ts';
import type { RoamView } from '../src/roam/roam_view.ts';
import { type Action, Walker } from '../src/roam/walker.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import { complaints, enfilade, type Home, inspect, makeHomes, missing, newFolder, openPage, patience, scan, serve, writeAnnotations } from './harness.ts';

declare const window: { roaming?: { walker: Walker; view: RoamView }; enfilade?: { viewer: Viewer } };

interface Episode {
  readonly id: string;
  readonly trajectory: string;
  readonly start: Vec3;
  readonly heading: number;
  readonly goals: readonly { readonly position: Vec3 }[];
}

/** What an expert did: Habitat's frame, where y is up and our y is -z. */
interface Expert {
  readonly locations: readonly Vec3[];
  readonly actions: readonly number[];
}

const actionNames: readonly (Action | undefined)[] = [undefined, 'forward', 'left', 'right']; // 0 is stop
const ready = (page: Page) => page.waitForFunction(() => window.roaming !== undefined, undefined, { timeout: patience });
const standing = (page: Page) => page.evaluate(() => {
  const { position, heading, length, actions, collisions } = window.roaming!.walker;
  return { position, heading, length, actions, collisions };
});

/** Runs in the page: of a small picture, how much its brightness spreads (0 to 127), and the share of its lightest and darkest pixels. */
function pictured(): { spread: number; extreme: number } {
  const pixels = window.roaming!.view.capture(160, 120);
  const grey = Array.from({ length: 160 * 120 }, (_, k) => (pixels[4 * k]! + pixels[4 * k + 1]! + pixels[4 * k + 2]!) / 3);
  const mean = grey.reduce((a, b) => a + b) / grey.length;
  const spread = Math.sqrt(grey.reduce((sum, value) => sum + (value - mean) ** 2, 0) / grey.length);
  return { spread, extreme: grey.filter((value) => value < 4 || value > 251).length / grey.length };
}

describe.skipIf(missing)('continuous walking', () => {
  let home: Home;
  let episodes: readonly Episode[];
  let page: Page;

  beforeAll(async () => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    makeHomes(data);
    writeAnnotations(data);
    enfilade('continuous', data);
    home = await serve(folder, data, join(folder, 'service.sqlite'));
    const answer = await fetch(`${home.server}/api/v1/continuous/val_seen/episodes?limit=500`);
    ({ episodes } = (await answer.json()) as { episodes: Episode[] });
  });
  afterAll(async () => {
    await home?.stop();
  });

  it("ends where the simulator's experts end, action by action", async () => {
    const floor = new Floor((await (await fetch(`${home.server}/api/v1/scans/${scan}/floor`)).json()) as FloorData);
    const experts = JSON.parse(gunzipSync(readFileSync(join(home.folder, 'vlnce/val_seen_gt.json.gz'))).toString()) as Record<string, Expert>;
    expect(episodes.length).toBeGreaterThan(0);
    let steps = 0;
    for (const { id, start, heading } of episodes) {
      const { locations, actions } = experts[id]!;
      const walker = new Walker(floor, floor.nearest(start)!, { heading, elevation: 0 });
      let at = 0;
      for (const action of actions) {
        const name = actionNames[action];
        if (!name) continue;
        walker.act(name);
        if (name !== 'forward') continue;
        const [x, y, z] = locations[++at]!;
        // The simulator has single precision, and the floor is sent to a hundredth of a millimetre; sliding makes little of either.
        const away = Math.hypot(walker.position[0] - x, walker.position[1] + z, walker.position[2] - y);
        expect(away, `episode ${id}, step ${at}`).toBeLessThan(0.002);
        ++steps;
      }
    }
    expect(steps).toBeGreaterThan(20);
  });

  it('is done by keys alone, and shows a building', async () => {
    page = await openPage(home, `/roam#${scan}`);
    await ready(page);
    const before = await standing(page);
    const { spread, extreme } = await page.evaluate(pictured);
    // A blank picture spreads 0; walls, furniture and light of a room spread 30 and more.
    expect(spread).toBeGreaterThan(12);
    expect(extreme).toBeLessThan(0.5);
    await page.locator('.roam-view canvas').focus();
    await page.keyboard.press('ArrowRight');
    expect((await standing(page)).heading).toBeCloseTo((before.heading + Math.PI / 12) % (2 * Math.PI), 6);
    await page.keyboard.press('ArrowLeft');
    for (let k = 0; k < 4; ++k) await page.keyboard.press('ArrowUp');
    const after = await standing(page);
    expect(after.actions).toBe(6);
    if (after.collisions === 0) expect(after.length).toBeCloseTo(1, 5);
    expect(after.length).toBeGreaterThan(0);
    await page.keyboard.down('w');
    await page.waitForFunction((length) => window.roaming!.walker.length !== length, after.length).catch(() => undefined); // a wall may be ahead
    await page.keyboard.up('w');
    await page.keyboard.down('e');
    await page.waitForFunction((heading) => window.roaming!.walker.heading !== heading, after.heading);
    await page.keyboard.up('e');
    await page.locator('.facts').getByText(/^\d+\.\d m$/).first().waitFor();
    await inspect(page, 'roam');
  });

  it('says where one stands in its address, and begins there', async () => {
    await page.waitForFunction(() => /^#home0001\/@-?[\d.]+,/.test(location.hash));
    const here = await standing(page);
    await page.waitForTimeout(300); // the address is written 0.2 s after the last change
    await page.reload();
    await ready(page);
    const again = await standing(page);
    // Addresses have centimetres and tenths of a degree.
    expect(Math.hypot(again.position[0] - here.position[0], again.position[1] - here.position[1])).toBeLessThan(0.02);
    expect(Math.abs(Math.sin(again.heading - here.heading))).toBeLessThan(0.01);
  });

  it('goes to the panorama near by and back, looking the same way', async () => {
    const { heading } = await standing(page);
    await page.getByRole('link', { name: 'Panorama near here' }).click();
    await page.waitForFunction(() => window.enfilade !== undefined);
    const seen = await page.evaluate(() => window.enfilade!.viewer.pose);
    expect(Math.abs(Math.sin(seen.heading - heading))).toBeLessThan(0.01);
    await page.getByRole('link', { name: 'Walk anywhere' }).click();
    await ready(page);
    const back = await standing(page);
    expect(Math.abs(Math.sin(back.heading - heading))).toBeLessThan(0.01);
  });

  it("shows an episode's path, and that its goal was reached", async () => {
    const { id, goals } = episodes[0]!;
    await page.goto(`${home.server}/roam?split=val_seen&id=${id}`);
    await ready(page);
    await page.locator('.instruction').waitFor();
    expect(await page.locator('.instruction img').count()).toBe(0); // it tries to be a script
    expect(await page.locator('.enfilade-map .route .goal').count()).toBe(1);
    await inspect(page, 'roam-episode');
    await page.evaluate((goal) => {
      const { walker } = window.roaming!;
      walker.place(walker.floor.nearest(goal)!);
    }, goals[0]!.position);
    await page.getByText(/: within 3 m$/).waitFor();
    await page.getByRole('button', { name: 'Back to the start' }).click();
    expect((await standing(page)).length).toBe(0);
  });

  it("shows the building as a doll's house with the path in it, turned by keys and entered by a click", async () => {
    await page.getByRole('button', { name: 'Doll’s house' }).click();
    const { spread } = await page.evaluate(pictured);
    expect(spread).toBeGreaterThan(12);
    await page.locator('.roam-view canvas').focus();
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('+');
    await inspect(page, 'roam-house');
    const box = (await page.locator('.roam-view canvas').boundingBox())!;
    const before = await standing(page);
    await page.mouse.click(box.x + box.width * 0.5, box.y + box.height * 0.5);
    for (let k = 0; k < 25 && (await standing(page)).position[0] === before.position[0]; ++k) {
      await page.mouse.click(box.x + (box.width * (2 + (k % 5))) / 8, box.y + (box.height * (2 + Math.floor(k / 5))) / 8);
    }
    expect((await standing(page)).position).not.toEqual(before.position);
    await page.getByRole('button', { name: 'Walk' }).click();
    await page.close();
  });

  it('is done by fingers', async () => {
    const phone = await openPage(home, `/roam#${scan}`, true);
    await ready(phone);
    const before = await standing(phone);
    await phone.getByRole('button', { name: 'Turn right by 15 degrees' }).tap();
    await phone.getByRole('button', { name: 'A step forward' }).tap();
    const after = await standing(phone);
    expect(after.actions).toBe(2);
    expect(after.heading).toBeCloseTo((before.heading + Math.PI / 12) % (2 * Math.PI), 6);
    await phone.close();
  });

  it('says what is missing where one cannot', async () => {
    const lost = await openPage(home, '/roam#nowhere');
    await lost.getByRole('alert').getByText('No scan of this name').waitFor();
    await inspect(lost, 'roam-nowhere');
    await lost.close();
  });

  it('is offered where it can be done', async () => {
    const first = await openPage(home, '/');
    await first.getByRole('link', { name: `Walk anywhere in ${scan}` }).click();
    await ready(first);
    await first.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
