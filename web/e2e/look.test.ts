/** What one looks at: first views, arrivals, the map, the whole screen, layers, rooms; and what pages say where there is nothing to look at. */
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { apply, degrees, type Direction, transpose, unitVector } from '../src/geometry/geometry.ts';
import type { Legends, Plan, Scan } from '../src/scan/scan.ts';
import { random } from '../src/testing/random.ts';
import { Surround } from '../src/viewer/surround.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import { isFirefox, launchWithoutGraphics } from './browsers.ts';
import { complaints, expectStill, type Home, inspect, missing, openPage, openRoamHome, scan, watch } from './harness.ts';

declare const window: { enfilade?: { viewer: Viewer }; verifier?: { readonly viewer: Viewer } };

const ready = (page: Page) => page.waitForFunction(() => window.enfilade !== undefined);
const pose = (page: Page) => page.evaluate(() => window.enfilade!.viewer.pose);

/** At the ceiling, where nobody arrives. */
const lookUp = (page: Page) => page.evaluate(() => window.enfilade!.viewer.look(window.enfilade!.viewer.pose.heading, 0.6));
/** At rest, and looking a little down. */
const arrived = (page: Page) => page.waitForFunction((down) =>
  !window.enfilade!.viewer.onTheWay && Math.abs(window.enfilade!.viewer.pose.elevation - down) < 1e-6, degrees(-14));

/** What the server says of the building: its scan, its plan, and how far it is from its viewpoints. */
class Measured {
  readonly scan: Scan;
  readonly plan: Plan;
  private readonly base: string;
  private readonly surrounds = new Map<number, Surround>();

  private constructor(base: string, read: Scan, plan: Plan) {
    [this.base, this.scan, this.plan] = [base, read, plan];
  }

  static async of(home: Home): Promise<Measured> {
    const base = `${home.server}/api/v1/scans/${scan}`;
    const json = async <T>(address: string) => (await (await fetch(address)).json()) as T;
    return new Measured(base, await json<Scan>(base), await json<Plan>(`${base}/plan`));
  }

  private async around(viewpoint: number): Promise<Surround> {
    const { id } = this.scan.viewpoints[viewpoint]!;
    const found = this.surrounds.get(viewpoint) ?? Surround.parse(await (await fetch(`${this.base}/viewpoints/${id}/distances`)).arrayBuffer());
    this.surrounds.set(viewpoint, found);
    return found;
  }

  /** Metres to what is in the middle of a view: of nine rays within 3 degrees the middle one. */
  async middle(viewpoint: number, { heading, elevation }: Direction): Promise<number> {
    const around = await this.around(viewpoint);
    const panoramaFromWorld = transpose(this.scan.viewpoints[viewpoint]!.rotation!);
    const beside = [-3, 0, 3].map(degrees);
    const metres = beside.flatMap((turn) => beside.map((up) =>
      around.at(apply(panoramaFromWorld, unitVector({ heading: heading + turn, elevation: elevation + up })))));
    return metres.sort((a, b) => a - b)[4]!;
  }

  /** The farthest that one could see in the middle of a view from there, a little down. */
  async farthest(viewpoint: number, elevation: number): Promise<number> {
    return Math.max(...await Promise.all(Array.from({ length: 72 }, (_, k) => this.middle(viewpoint, { heading: degrees(5 * k), elevation }))));
  }

  pictured(): number[] {
    return this.scan.viewpoints.flatMap(({ included, rotation }, v) => (included && rotation ? [v] : []));
  }
}

describe.skipIf(missing)('where one looks', () => {
  let home: Home;
  let measured: Measured;
  let page: Page;

  beforeAll(async () => {
    home = await openRoamHome();
    measured = await Measured.of(home);
    page = await openPage(home, `/view#${scan}`);
    await ready(page);
  });
  afterAll(async () => {
    await home?.stop();
  });

  /** At least 2 m in the middle of the view, or as far as one can see there. */
  async function expectOpen(viewpoint: number, look: Direction, what: string): Promise<void> {
    const most = await measured.farthest(viewpoint, look.elevation);
    expect(await measured.middle(viewpoint, look), `${what}, at viewpoint ${viewpoint}, of ${most.toFixed(1)} m at most`)
      .toBeGreaterThanOrEqual(Math.min(2, most));
  }

  it('twenty random starts each have something at least 2 m away in the middle', async () => {
    const next = random(51);
    const all = measured.pictured();
    const starts = Array.from({ length: 20 }, () => all[Math.floor(next() * all.length)]!);
    let far = 0;
    for (const [k, start] of starts.entries()) {
      await page.goto(`${home.server}/view?start=${k}#${scan}/${measured.scan.viewpoints[start]!.id}`);
      await ready(page);
      const { viewpoint, ...look } = await pose(page);
      expect(viewpoint).toBe(start);
      await expectOpen(viewpoint, look, `start ${k}`);
      far += (await measured.middle(viewpoint, look)) >= 2 ? 1 : 0;
    }
    expect(far, 'hardly any viewpoint stands in a closet').toBeGreaterThanOrEqual(18);
  });

  it('arrivals from elsewhere look at what is open, and steps do not end at a wall', async () => {
    const next = random(52);
    const all = measured.pictured();
    for (let k = 0; k < 20; ++k) {
      const from = await pose(page);
      const neighbours = measured.scan.viewpoints[from.viewpoint]!.neighbours;
      const isStep = k % 2 === 1 && neighbours.length > 0;
      const others = isStep ? neighbours : all.filter((v) => v !== from.viewpoint && !neighbours.includes(v));
      const to = others[Math.floor(next() * others.length)]!;
      expect(await page.evaluate((viewpoint) => window.enfilade!.viewer.go(viewpoint), to)).toBe(true);
      const { viewpoint, ...look } = await pose(page);
      expect(viewpoint).toBe(to);
      if (!isStep) await expectOpen(to, look, `arrival ${k}`);
      else expect(await measured.middle(to, look), `step ${k}`).toBeGreaterThanOrEqual(Math.min(0.8, await measured.farthest(to, look.elevation)));
    }
  });

  it('rooms, clicks on the map and the rest of the address do, too', async () => {
    await page.getByRole('region', { name: 'Rooms' }).waitFor();
    const rooms = page.getByRole('region', { name: 'Rooms' }).getByRole('button');
    for (let k = 0; k < Math.min(4, await rooms.count()); ++k) {
      await lookUp(page);
      await rooms.nth(k).click();
      await arrived(page);
      expect(await rooms.nth(k).getAttribute('aria-current')).toBe('location');
      const { viewpoint, ...look } = await pose(page);
      await expectOpen(viewpoint, look, `room ${k}`);
    }
    const before = (await pose(page)).viewpoint;
    const dots = page.locator('.enfilade-map .dots circle');
    await lookUp(page);
    await dots.nth((before + 3) % await dots.count()).click();
    await arrived(page);
    const there = await pose(page);
    await expectOpen(there.viewpoint, there, 'a click on the map');
    const other = measured.pictured().find((v) => v !== there.viewpoint)!;
    await lookUp(page);
    await page.evaluate((hash) => { location.hash = hash; }, `#${scan}/${measured.scan.viewpoints[other]!.id}`);
    await arrived(page);
    await expectOpen(other, await pose(page), 'an address without a heading');
  });

  it('the view is wide, looks a little down, fits the window, and opens to 110 degrees', async () => {
    await page.goto(`${home.server}/view?wide#${scan}`);
    await ready(page);
    const first = await pose(page);
    expect(first.elevation).toBeCloseTo(degrees(-14));
    const opening = ({ vfov, width, height }: { vfov: number; width: number; height: number }) =>
      2 * Math.atan((Math.tan(vfov / 2) * width) / height);
    const view = () => page.evaluate(() => window.enfilade!.viewer.view);
    expect((await view()).vfov).toBeCloseTo(degrees(75));
    expect(opening(await view())).toBeGreaterThan(degrees(75));
    expect(opening(await view())).toBeLessThan(degrees(100.1));
    await page.setViewportSize({ width: 1440, height: 600 });
    await page.waitForFunction(() => window.enfilade!.viewer.view.height < 600);
    await expect.poll(async () => opening(await view())).toBeCloseTo(degrees(100));
    await page.setViewportSize({ width: 1440, height: 900 });
    await page.locator('.enfilade-canvas').focus();
    for (let k = 0; k < 12; ++k) await page.keyboard.press('-');
    expect((await pose(page)).vfov).toBeCloseTo(degrees(110));
    // Discs far to the side have a place in the picture, or none.
    const odd = await page.evaluate(() => [...document.querySelectorAll('.enfilade-viewer svg path, .enfilade-viewer svg polygon')]
      .map((one) => (one.getAttribute('d') ?? '') + (one.getAttribute('points') ?? '')).filter((text) => /NaN|Infinity|\d{7}/.test(text)));
    expect(odd).toEqual([]);
  });

  it('without a viewpoint it begins where the pictures of the building are taken from', async () => {
    const outlook = await (await fetch(`${home.server}/api/v1/scans/${scan}/outlook`)).json() as { viewpoint: string; heading: number };
    const { viewpoint, heading } = await page.evaluate(() => window.enfilade!.viewer.pose);
    expect(measured.scan.viewpoints[viewpoint]!.id).toBe(outlook.viewpoint);
    expect(heading).toBeCloseTo(outlook.heading);
  });

  it('an arrow points at any viewpoint that is out of sight', async () => {
    const arrow = page.locator('.enfilade-next');
    const { to, heading } = await page.evaluate(() => {
      const { viewer } = window.enfilade!;
      const from = viewer.scan.viewpoints[viewer.pose.viewpoint]!.position;
      const far = viewer.scan.viewpoints.findIndex(({ position }) => Math.hypot(position[0] - from[0], position[1] - from[1]) > 2);
      const { position } = viewer.scan.viewpoints[far]!;
      return { to: far, heading: Math.atan2(position[0] - from[0], position[1] - from[1]) };
    });
    await page.evaluate(([viewpoint, away]) => {
      window.enfilade!.viewer.pointTo(viewpoint);
      window.enfilade!.viewer.look(away!, 0);
    }, [to, heading + 2]);
    expect(await arrow.getAttribute('data-side')).toBe('left');
    expect(await arrow.isVisible()).toBe(true);
    await page.evaluate((away) => window.enfilade!.viewer.look(away, 0), heading - 2);
    expect(await arrow.getAttribute('data-side')).toBe('right');
    await page.evaluate((away) => window.enfilade!.viewer.look(away, 0), heading);
    expect(await arrow.isVisible()).toBe(false);
    await page.evaluate((away) => {
      window.enfilade!.viewer.look(away, 0);
      window.enfilade!.viewer.pointTo(undefined);
    }, heading + 2);
    expect(await arrow.isVisible()).toBe(false);
  });

  it('a disc under the mouse says the name of its room, and screen readers hear how many places there are', async () => {
    await page.getByRole('region', { name: 'Rooms' }).waitFor();
    await page.evaluate(() => {
      const { viewer } = window.enfilade!;
      const [step] = viewer.steps();
      const [from, to] = [viewer.scan.viewpoints[viewer.pose.viewpoint]!.position, viewer.scan.viewpoints[step!.viewpoint]!.position];
      viewer.look(Math.atan2(to[0] - from[0], to[1] - from[1]), -Math.atan2(1.5, Math.hypot(to[0] - from[0], to[1] - from[1])));
    });
    const box = (await page.locator('.enfilade-canvas').boundingBox())!;
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    const names = new Set(measured.plan.rooms.map(({ name }) => name));
    const hint = await page.locator('.view > .enfilade-hint').textContent();
    expect(names.has(hint!.split(',')[0]!), hint!).toBe(true);
    const said = await page.locator('.view > .enfilade-said').textContent();
    expect(said).toMatch(/^Viewpoint \d+.*\. (1 place|[2-9] places) to go to\.$/);
  });

  it('the name of the room is not under the buttons, on a phone and on the whole screen', async () => {
    const phone = await openPage(home, `/view#${scan}`, true);
    await ready(phone);
    expect(await phone.getByRole('link', { name: 'Walk anywhere' }).isVisible()).toBe(true);
    const overlap = async (one: Page) => {
      await one.locator('.view-place:not([hidden])').waitFor();
      return one.evaluate(() => {
        const name = document.querySelector('.view-place')!.getBoundingClientRect();
        const buttons = [...document.querySelectorAll('.view-tools :is(button, a)')].map((one) => one.getBoundingClientRect());
        const inside = [name, ...buttons].every(({ left, right }) => left >= 0 && right <= innerWidth);
        const over = buttons.filter((b) => b.left < name.right && b.right > name.left && b.top < name.bottom && b.bottom > name.top);
        return { inside, over: over.length };
      });
    };
    // The longest name of all buildings that there are.
    await phone.evaluate(() => window.enfilade!.viewer.setNames(new Map([[window.enfilade!.viewer.pose.viewpoint, 'living and dining room']])));
    expect(await overlap(phone)).toEqual({ inside: true, over: 0 });
    expect(await phone.locator('.keys').first().isVisible(), 'a phone has no arrow keys').toBe(false);
    await phone.close();
    expect(await overlap(page)).toEqual({ inside: true, over: 0 });
  });

  // Playwright does not bring Firefox to the whole screen.
  it.skipIf(isFirefox)('the whole screen has the map, and an episode its instruction and its fly-through', async () => {
    const one = await openPage(home, `/view?split=val_seen&id=1_0`);
    await ready(one);
    const seen = async () => one.evaluate(() => {
      const visible = (selector: string) => {
        const element = document.querySelector<HTMLElement>(`:fullscreen ${selector}`);
        const box = element?.getBoundingClientRect();
        return box !== undefined && box.width > 40 && box.height > 15 && box.right <= innerWidth && box.bottom <= innerHeight
          && element!.checkVisibility();
      };
      return [visible('.enfilade-map'), visible('.instruction'), visible('.enfilade-player button')];
    });
    await one.getByRole('button', { name: 'Full screen' }).click();
    await one.waitForFunction(() => document.fullscreenElement !== null);
    await one.getByRole('button', { name: 'Leave full screen' }).waitFor();
    expect(await seen()).toEqual([true, true, true]);
    const [map, episode] = await Promise.all([one.locator('.view > .map').boundingBox(), one.locator('.view > .episode').boundingBox()]);
    expect(episode!.y + episode!.height).toBeLessThanOrEqual(map!.y);
    await one.getByRole('button', { name: 'Play' }).click();
    await one.getByRole('button', { name: 'Pause' }).click();
    await one.waitForTimeout(300);
    expect(await one.getByRole('button', { name: 'Pause' }).count(), 'it has paused').toBe(0);
    await one.getByRole('button', { name: 'Leave full screen' }).click();
    await one.locator('.side .panel .instruction').waitFor();
    await one.locator('.side > .map .enfilade-map').waitFor();
    expect(await one.locator('.side').evaluate((side) => [...side.children].map(({ className }) => className))).toEqual(['map', 'panel']);
    expect(await one.locator('.panel').evaluate((panel) => panel.firstElementChild!.className)).toBe('episode');
    await one.close();
  });

  it('a fly-through ends with something to see', async () => {
    const one = await openPage(home, '/view?split=val_seen&id=1_0');
    await ready(one);
    await one.getByLabel('Speed').selectOption('4');
    await one.getByRole('button', { name: 'Play' }).click();
    await one.getByRole('button', { name: 'Replay' }).waitFor();
    const { viewpoint, ...look } = await pose(one);
    expect(await measured.middle(viewpoint, look)).toBeGreaterThanOrEqual(Math.min(0.9, await measured.farthest(viewpoint, look.elevation)));
    await one.close();
  });

  it('no label of the map is under a disc', async () => {
    await page.locator('.enfilade-map .names text').first().waitFor();
    const covered = await page.evaluate(() => {
      const boxes = (selector: string) => [...document.querySelectorAll(`.enfilade-map ${selector}`)].map((one) => one.getBoundingClientRect());
      const order = [...document.querySelector('.enfilade-map')!.children].map((one) => one.getAttribute('class'));
      const [labels, discs] = [boxes('.names text'), boxes('.dots circle')];
      const hidden = labels.filter((label) => discs.some((disc) => {
        const [x, y] = [(disc.left + disc.right) / 2, (disc.top + disc.bottom) / 2];
        const [dx, dy] = [Math.max(label.left - x, x - label.right, 0), Math.max(label.top - y, y - label.bottom, 0)];
        return Math.hypot(dx, dy) < disc.width / 2 - 1;
      }));
      return { labels: labels.length, hidden: hidden.length, above: order.indexOf('names') > order.indexOf('dots') };
    });
    expect(covered.labels).toBeGreaterThan(1);
    expect(covered.above).toBe(true);
    expect(covered.hidden, 'labels that a disc is behind').toBeLessThanOrEqual(Math.floor(covered.labels / 6));
  });

  it('depth is scaled to what is there, with its legend, and classes have colours of their own', async () => {
    const { viewpoint } = await pose(page);
    const { id } = measured.scan.viewpoints[viewpoint]!;
    const { depth, classes } = await (await fetch(`${home.server}/api/v1/scans/${scan}/viewpoints/${id}/legends`)).json() as Legends;
    expect(depth!.nearest).toBeGreaterThan(0.2);
    expect(depth!.farthest).toBeLessThan(12); // a flat of 60 square metres, and not the street
    await page.getByRole('combobox', { name: 'Layer' }).selectOption('depth');
    const legend = page.getByRole('region', { name: 'Legend' });
    await legend.getByText(`${depth!.nearest.toFixed(1)} m or less`).waitFor();
    await legend.getByText(`${depth!.farthest.toFixed(1)} m or more`).waitFor();
    expect(new Set(classes!.map(({ colour }) => colour)).size).toBe(classes!.length);
    await page.getByRole('combobox', { name: 'Layer' }).selectOption('colour');
  });

  it('the panel has the rooms with pictures, episodes, and ways to follow one and to verify the graph', async () => {
    await page.getByRole('region', { name: 'Episodes here' }).waitFor();
    const names = measured.plan.rooms.filter(({ name, viewpoints }) => name && viewpoints.length > 0).map(({ name }) => name);
    expect(await page.locator('.room-cards button').count()).toBe(names.length);
    const pictures = page.locator('section[aria-label="Rooms"] > .room-cards img');
    for (let k = 0; k < await pictures.count(); ++k) {
      await pictures.nth(k).scrollIntoViewIfNeeded();
      await expect.poll(() => pictures.nth(k).evaluate((one: HTMLImageElement) => one.naturalWidth), { timeout: 30_000 }).toBe(320);
    }
    const episodes = page.getByRole('region', { name: 'Episodes here' });
    expect(await episodes.getByRole('listitem').count()).toBe(3);
    const all = episodes.getByRole('link', { name: '18 episodes of R2R val_seen here' });
    expect(await all.getAttribute('href')).toBe(`/episodes?split=val_seen&scan=${scan}`);
    expect(await episodes.getByRole('link', { name: 'Follow an instruction here' }).getAttribute('href')).toBe(`/try?scan=${scan}`);
    expect(await page.getByRole('link', { name: 'Verify graph' }).getAttribute('href')).toMatch(new RegExp(`^/verify#${scan}/\\w+/`));
    await episodes.getByRole('link', { name: '1_1' }).click();
    await page.waitForURL(/id=1_1/);
    await ready(page);
    await page.goto(`${home.server}/view#${scan}`);
    await ready(page);
  });

  it('verifying has numbers on the map, and rows mark their disc and their dot', async () => {
    const verify = await openPage(home, `/verify#${scan}`);
    await verify.waitForFunction(() => window.verifier !== undefined);
    const { storeys } = measured.scan;
    expect(await verify.locator('.enfilade-map .numbers text').allTextContents()).toEqual(storeys[0]!.viewpoints.map(String));
    const row = verify.locator('tbody tr').first();
    await row.hover();
    const number = /Viewpoint (\d+)/.exec((await row.textContent())!)![1]!;
    expect(await verify.locator('.enfilade-map .route .marked').count()).toBe(1);
    const at = await verify.evaluate((v) => {
      const ring = document.querySelector('.enfilade-map .route .marked')!;
      const text = [...document.querySelectorAll('.enfilade-map .numbers text')].find((one) => one.textContent === v)!;
      return [ring.getAttribute('cx'), text.getAttribute('x')];
    }, number);
    expect(at[0]).toBe(at[1]);
    // In the picture, too: its hint, or an arrow to it.
    expect(await verify.locator('.view > .enfilade-hint:not([hidden]), .view > .enfilade-next:not([hidden])').count()).toBeGreaterThan(0);
    await verify.mouse.move(5, 5);
    await verify.locator('.enfilade-map .route .marked').waitFor({ state: 'detached' });
    await row.getByRole('button').first().focus();
    expect(await verify.locator('.enfilade-map .route .marked').count()).toBe(1);
    await inspect(verify, 'verify-marked');
    await verify.close();
  });

  // Firefox does not measure it.
  it.skipIf(isFirefox).each([
    [`/view#${scan}`, false], [`/view#${scan}`, true], ['/view?split=val_seen&id=1_0', false], ['/view?split=val_seen&id=1_0', true],
    [`/verify#${scan}`, false], [`/verify#${scan}`, true],
  ] as const)('nothing moves on %s when it is loaded (phone: %s)', async (address, isPhone) => {
    const one = await openPage(home, address, isPhone);
    await one.locator('.enfilade-map').waitFor();
    await one.waitForLoadState('networkidle');
    await expectStill(one);
    await one.close();
  });

  it.each([
    ['/view?split=val_seen&id=nosuch', 'Split val_seen has no episode "nosuch".', '/episodes?split=val_seen'],
    ['/view#nosuch', 'This server has no building "nosuch".', '/'],
    [`/view#${scan}/nosuch`, `${scan} has no viewpoint "nosuch".`, `/view#${scan}/`],
    ['/view', 'Choose one in the list of buildings.', '/'],
    ['/verify#nosuch', 'This server has no building "nosuch".', '/'],
    ['/verify', 'Choose one in the list of buildings.', '/'],
  ] as const)('%s names what is not there, and has a way back', async (address, words, back) => {
    const one = await openPage(home, address);
    await one.getByText(words).waitFor();
    expect(await one.locator(`main a[href="${back}"]`).count()).toBeGreaterThan(0);
    expect(await one.getByRole('navigation', { name: 'Pages' }).getByRole('link').count()).toBeGreaterThan(3);
    expect(await one.locator('h1').count()).toBe(1);
    await one.close();
  });

  it('says in plain words that a browser without WebGL cannot show the buildings, on every page with a viewer', async () => {
    const browser = await launchWithoutGraphics();
    const one = await browser.newPage();
    watch(one);
    for (const address of [`/view#${scan}`, '/view?split=val_seen&id=1_0', `/verify#${scan}`, '/try?split=val_seen&id=1_0', `/roam#${scan}`]) {
      await one.goto('about:blank');
      await one.goto(home.server + address);
      await one.getByRole('heading', { name: 'This browser cannot show the buildings' }).waitFor();
      expect(await one.locator('main').textContent(), address).not.toMatch(/THREE|WebGLRenderer/);
      expect(await one.getByRole('navigation', { name: 'Pages' }).getByRole('link').count()).toBeGreaterThan(3);
      expect(await one.locator('main').getByRole('link').count()).toBeGreaterThan(0);
    }
    await inspect(one, 'no-graphics');
    await browser.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
