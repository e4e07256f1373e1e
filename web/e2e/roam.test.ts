/** Continuous walking: the browser's steps end where the simulator's do, and what it shows is a building. */
import { readFileSync } from 'node:fs';
import { availableParallelism, loadavg } from 'node:os';
import { join } from 'node:path';
import { gunzipSync } from 'node:zlib';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Vec3 } from '../src/geometry/geometry.ts';
import { Floor, type FloorData } from '../src/roam/floor.ts';
import type { RoamView } from '../src/roam/roam_view.ts';
import { type Action, Walker } from '../src/roam/walker.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import { isFirefox, launchWithoutGraphics } from './browsers.ts';
import { complaints, expectStill, type Home, inspect, missing, openPage, openRoamHome, patience, scan, watch } from './harness.ts';

declare const window: { roaming?: { walker: Walker; view: RoamView }; enfilade?: { viewer: Viewer }; flew?: boolean };

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
/** In a mode, and at rest there. */
const isIn = (page: Page, mode: 'inside' | 'house') =>
  page.waitForFunction((wanted) => window.roaming!.view.mode === wanted && !window.roaming!.view.flying, mode, { timeout: patience });
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
    home = await openRoamHome();
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
    await page.waitForTimeout(600); // the address is written 0.4 s after the last change
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

  it("shows the building as a doll's house with the path in it, turned by keys, and flies into it where one clicks", async () => {
    await page.evaluate(() => {
      const { view } = window.roaming!;
      const watch = setInterval(() => {
        window.flew ||= view.flying;
        if (window.flew) clearInterval(watch);
      }, 5);
    });
    await page.getByRole('button', { name: 'Doll’s house' }).click();
    await page.waitForFunction(() => window.flew);
    await isIn(page, 'house');
    const { spread } = await page.evaluate(pictured);
    expect(spread).toBeGreaterThan(12);
    await page.locator('.roam-view canvas').focus();
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('+');
    await page.waitForURL(/[?&]view=house/);
    await inspect(page, 'roam-house');
    const box = (await page.locator('.roam-view canvas').boundingBox())!;
    const before = await standing(page);
    await page.mouse.click(box.x + box.width * 0.5, box.y + box.height * 0.5);
    for (let k = 0; k < 25 && (await standing(page)).position[0] === before.position[0]; ++k) {
      await page.mouse.click(box.x + (box.width * (2 + (k % 5))) / 8, box.y + (box.height * (2 + Math.floor(k / 5))) / 8);
    }
    expect((await standing(page)).position).not.toEqual(before.position);
    await isIn(page, 'inside');
    await page.waitForFunction(() => !location.search.includes('view=house'));
    // It looks to where there is most floor: a person stands nowhere with the nose to a wall.
    const ahead = await page.evaluate(() => {
      const { floor, standing: at, heading } = window.roaming!.walker;
      const metres = (turn: number) => floor.ahead(at, Math.sin(turn), Math.cos(turn), 7).metres;
      return [metres(heading), Math.max(...Array.from({ length: 72 }, (_, k) => metres((k * Math.PI) / 36)))];
    });
    expect(ahead[0]!).toBeGreaterThan(0.6 * ahead[1]!);
    await page.close();
  });

  it('begins with the doll’s house where the address says so, and goes in at once where people asked for less motion', async () => {
    const still = await openPage(home, `/roam?view=house#${scan}`);
    await ready(still);
    await isIn(still, 'house');
    if (!isFirefox) await still.emulateMedia({ reducedMotion: 'reduce' }); // WebDriver BiDi cannot
    const { frames } = await still.evaluate(() => ({ frames: window.roaming!.view.frames }));
    await still.getByRole('button', { name: 'Go in' }).click();
    await isIn(still, 'inside');
    if (!isFirefox) expect(await still.evaluate(() => window.roaming!.view.frames) - frames).toBeLessThan(4);
    expect(await still.evaluate(() => document.activeElement?.tagName)).toBe('CANVAS'); // the button is gone
    await still.close();
  });

  it('goes to a room, to a click on the floor and on the map, and has a link to where one stands', async () => {
    const one = await openPage(home, `/roam#${scan}`);
    await ready(one);
    const rooms = one.getByRole('combobox', { name: 'Go to a room' });
    await rooms.waitFor();
    const names = (await rooms.locator('option').allTextContents()).slice(1);
    expect(names.length).toBeGreaterThan(2);
    const places = new Set<string>();
    for (const name of names) {
      await rooms.selectOption({ label: name });
      const { position } = await standing(one);
      places.add(position.map((x) => x.toFixed(1)).join());
    }
    expect(places.size).toBe(names.length);
    await one.getByText(`You stand in the ${names.at(-1)!.replace(/,.*/, '')} now.`).waitFor({ state: 'attached' });

    // A ring lies where a click leads: straight ahead as far as the floor goes.
    const toAim = () => one.evaluate(() => {
      const { walker, view } = window.roaming!;
      const { end } = walker.floor.ahead(walker.standing, Math.sin(walker.heading), Math.cos(walker.heading), 2.5);
      const { x, y } = view.ringAt(end.position)!;
      const { left, top } = view.canvas.getBoundingClientRect();
      return { end: end.position, x: left + x, y: top + y };
    });
    let aim = await toAim();
    await expect.poll(async () => { // the ring goes while the view changes
      aim = await toAim();
      await one.mouse.move(aim.x - 3, aim.y);
      await one.mouse.move(aim.x, aim.y);
      return one.locator('.roam-ring').isVisible();
    }, { timeout: patience, interval: 300 }).toBe(true);
    await one.mouse.click(aim.x, aim.y);
    await one.waitForFunction(([x, y]) => {
      const { position } = window.roaming!.walker;
      return Math.hypot(position[0] - x!, position[1] - y!) < 0.3;
    }, aim.end);
    expect((await standing(one)).length).toBeGreaterThan(0.5);

    const before = await standing(one);
    const map = (await one.locator('.enfilade-map').boundingBox())!;
    for (const [across, down] of [[0.35, 0.4], [0.6, 0.6], [0.5, 0.3]] as const) {
      await one.mouse.click(map.x + map.width * across, map.y + map.height * down);
    }
    await one.waitForTimeout(300); // the way to the click before has ended
    const after = await standing(one);
    expect(after.position).not.toEqual(before.position);
    expect(after.length).toBe(0);

    await one.getByRole('button', { name: 'Share' }).click();
    await one.getByText('Link copied').or(one.getByRole('textbox', { name: 'Link to this view' })).waitFor();
    if (!isFirefox) {
      await one.getByRole('button', { name: 'Full screen' }).click();
      await one.waitForFunction(() => document.fullscreenElement?.querySelector('.enfilade-map'));
      await one.getByRole('button', { name: 'Leave full screen' }).click();
      await one.locator('.side .enfilade-map').waitFor();
    }
    await one.close();
  });

  it.skipIf(isFirefox)('draws 15 frames a second without a GPU', async () => {
    const fast = await openPage(home, `/roam#${scan}`);
    await fast.setViewportSize({ width: 1060 + 384, height: 846 + 56 });
    await ready(fast);
    await fast.locator('.roam-view canvas').focus();
    const seconds = 3;
    const rates: number[] = [];
    for (const keys of [['w', 'e'], ['e'], ['w', 'q']]) {
      for (const key of keys) await fast.keyboard.down(key);
      await fast.waitForTimeout(1000); // it finds its pace
      const frames = await fast.evaluate((wait) => new Promise<number>((resolve) => {
        const { view } = window.roaming!;
        const before = view.frames;
        setTimeout(() => resolve(view.frames - before), wait);
      }), 1000 * seconds);
      for (const key of keys) await fast.keyboard.up(key);
      rates.push(frames / seconds);
    }
    const { scale, cost, size } = await fast.evaluate(() => {
      const { view } = window.roaming!;
      return { scale: view.scale, cost: view.cost, size: [view.canvas.clientWidth, view.canvas.clientHeight] };
    });
    console.log(`Continuous walking at ${size.join(' x ')}: ${rates.map((rate) => rate.toFixed(1)).join(', ')} frames a second, at a scale of `
      + `${scale.toFixed(2)}, ${cost.calls} draws of ${cost.triangles} triangles`);
    // The figure is for a machine that does nothing else; tests share theirs with builds.
    const ours = Math.min(1, availableParallelism() / loadavg()[0]!);
    expect(Math.max(...rates), `${(100 * ours).toFixed(0)} % of the machine`).toBeGreaterThan(15 * ours);
    await fast.close();
  });

  it('stands still while it is loaded', async () => {
    for (const phone of [false, true]) {
      const one = await openPage(home, `/roam#${scan}`, phone);
      await ready(one);
      await one.waitForLoadState('networkidle');
      await expectStill(one);
      await one.close();
    }
  });

  it.skipIf(isFirefox)('is done by fingers', async () => { // WebDriver BiDi has none
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

  it.each([
    ['/roam#nowhere', 'nowhere'], [`/roam#${scan}/nosuch`, `${scan} has no viewpoint nosuch`], ['/roam', 'The address names no building'],
    ['/roam?split=val_seen&id=nosuch', 'Split val_seen has no continuous episode nosuch'],
    ['/roam?split=val_seen&trajectory=99', 'Split val_seen has no continuous episode of path 99'],
  ])('names what is wrong in %s, and a way back', async (address, text) => {
    const lost = await openPage(home, address);
    await lost.getByRole('alert').getByText(text).waitFor();
    await lost.locator('main').getByRole('link', { name: 'Go to Buildings' }).waitFor();
    await lost.locator('.site [aria-current]', { hasText: 'Buildings' }).waitFor();
    if (address === '/roam#nowhere') await inspect(lost, 'roam-nowhere');
    await lost.close();
  });

  it('says before it fetches anything that a browser cannot show it', async () => {
    const browser = await launchWithoutGraphics();
    const lost = await browser.newPage();
    watch(lost);
    const asked: string[] = [];
    lost.on('request', (request) => { asked.push(request.url()); });
    await lost.goto(`${home.server}/roam#${scan}`);
    await lost.getByRole('heading', { name: 'This browser cannot show the buildings' }).waitFor();
    expect(asked.filter((address) => address.includes('mesh.glb'))).toEqual([]);
    await browser.close();
  });

  it('is offered where it can be done', async () => {
    const first = await openPage(home, '/');
    await first.getByRole('link', { name: `Walk anywhere in ${scan}` }).click();
    await ready(first);
    await first.goto(home.server);
    await first.getByRole('link', { name: `Doll’s house of ${scan}` }).click();
    await ready(first);
    await isIn(first, 'house');
    // From the picture on top to the same place, as the building's viewpoints have it.
    await first.goto(home.server);
    const outlook = await (await fetch(`${home.server}/api/v1/scans/${scan}/outlook`)).json() as { viewpoint: string };
    await first.waitForFunction((id) => document.querySelector<HTMLAnchorElement>('.hero a[href^="/roam#"]')?.href.includes(id), outlook.viewpoint);
    await first.getByRole('link', { name: 'Walk anywhere', exact: true }).click();
    await ready(first);
    const { viewpoints } = await (await fetch(`${home.server}/api/v1/scans/${scan}`)).json() as { viewpoints: { id: string; position: Vec3 }[] };
    const [x, y] = viewpoints.find(({ id }) => id === outlook.viewpoint)!.position;
    const { position } = await standing(first);
    expect(Math.hypot(position[0] - x, position[1] - y)).toBeLessThan(0.5);
    await first.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
