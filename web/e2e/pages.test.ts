import { readFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { describe, expect, it } from 'vitest';
import type { Page } from 'playwright-core';
import { fileURLToPath } from 'node:url';
import { createServer } from 'vite';
import type { Viewer } from '../src/viewer/viewer.ts';
import { download, goBack, isFirefox } from './browsers.ts';
import { complaints, type Home, inspect, makeHomes, missing, openPage, patience, results, scan, withHome } from './harness.ts';

declare const window: { enfilade?: { viewer: Viewer }; walker?: { viewer: Viewer } };

const configFile = fileURLToPath(new URL('../vite.config.ts', import.meta.url));
const pagesFolder = fileURLToPath(new URL('../pages', import.meta.url));

/** The panorama of the first page has begun to turn. */
const begun = (page: Page) => page.waitForFunction(() => document.getAnimations().some(({ effect }) =>
  effect instanceof KeyframeEffect && effect.getKeyframes().length > 20));

/**
 * How far the panorama as it stood before it turned is from the picture that the server drew of the
 * same view: the mean over all values, of 255.
 */
async function differenceFromStill(page: Page): Promise<number> {
  await page.evaluate(() => {
    const scene = document.querySelector<HTMLElement>('.hero .scene')!;
    scene.style.cssText = 'position: fixed; z-index: 9; left: 0; top: 0; right: auto; bottom: auto; width: 640px; height: 400px';
  });
  await page.waitForTimeout(500); // until it has its new size
  await page.evaluate(() => { for (const animation of document.getAnimations()) { animation.pause(); animation.currentTime = 0; } });
  await page.evaluate(() => { document.querySelector<HTMLElement>('.hero .box')!.style.animation = 'none'; });
  const drawn = await page.screenshot({ clip: { x: 0, y: 0, width: 640, height: 400 } });
  return page.evaluate(async (screenshot) => {
    const pixels = async (source: string) => {
      const image = new Image();
      image.src = source;
      await image.decode();
      const context = Object.assign(document.createElement('canvas'), { width: 640, height: 400 }).getContext('2d')!;
      context.drawImage(image, 0, 0, 640, 400);
      return context.getImageData(0, 0, 640, 400).data;
    };
    const still = document.querySelector<HTMLImageElement>('.cards img')!.src;
    const [a, b] = await Promise.all([pixels(still), pixels(screenshot)]);
    return a.reduce((sum, value, k) => sum + Math.abs(value - b[k]!), 0) / (640 * 400 * 3);
  }, `data:image/png;base64,${drawn.toString('base64')}`);
}

describe.skipIf(missing)('the pages', () => {
  let home: Home;
  withHome((opened) => { home = opened; });

  it('take a team from its making to the leaderboard', async () => {
    const page = await openPage(home, '/submit');
    await page.getByLabel("The team's name").fill('<b>Team</b> "A"');
    await page.getByRole('button', { name: 'Create team' }).click();
    await page.locator('.token').waitFor();
    await inspect(page, 'submit-team');
    await page.getByRole('button', { name: 'Log in' }).click();
    await page.getByText('You are').waitFor();

    const file = (content: string) => ({ name: 'r.json', mimeType: 'application/json', buffer: Buffer.from(content) });
    await page.getByLabel('Method').fill('walks');
    await page.getByLabel('Results file').setInputFiles(file('[{"instr_id": "1_0"}]'));
    await page.getByRole('button', { name: 'Check and submit' }).click();
    await page.getByRole('alert').waitFor();
    expect(await page.getByRole('alert').textContent()).toContain('$[0]');
    await inspect(page, 'submit-faults');

    await page.getByLabel('Paper').fill('https://example.org/paper');
    await page.getByLabel('Results file').setInputFiles(file(await results(home, true)));
    await page.getByRole('button', { name: 'Check and submit' }).click();
    await page.getByText('The file is valid').waitFor();
    await page.getByRole('cell', { name: 'scored' }).waitFor();
    await page.getByLabel('Method').fill('stays');
    await page.getByLabel('Results file').setInputFiles(file(await results(home, false)));
    await page.getByRole('button', { name: 'Check and submit' }).click();
    await page.getByText('submission 2').first().waitFor();
    await inspect(page, 'submit-scored');

    await page.goto(`${home.server}/leaderboard`);
    await page.getByRole('cell', { name: '<b>Team</b> "A"' }).waitFor();
    expect(await page.locator('tbody tr').count()).toBe(1); // the better of the two
    expect(await page.locator('tbody').textContent()).toContain('100.0');
    // An interval without a length is not drawn: of all that are, one reads the ends.
    expect(await page.locator('td:has(svg.interval) > .range').count()).toBe(await page.locator('svg.interval').count());
    await page.locator('td[data-label="TL, m"] > .range').getByText(/^\d+\.\d\d–\d+\.\d\d$/).waitFor();
    expect(await page.getByRole('link', { name: 'Paper of walks' }).getAttribute('href')).toBe('https://example.org/paper');
    await page.getByRole('heading', { name: 'Progress' }).waitFor();
    const column = page.getByRole('columnheader', { name: 'NE' });
    await page.getByRole('button', { name: 'NE' }).click();
    expect(await column.getAttribute('aria-sort')).toBe('ascending');
    await page.getByRole('button', { name: 'NE' }).click();
    expect(await column.getAttribute('aria-sort')).toBe('descending');
    await page.reload(); // the address has it
    await page.getByRole('columnheader', { name: 'NE' }).and(page.locator('[aria-sort=descending]')).waitFor();
    await inspect(page, 'leaderboard-scored');

    await page.goto(`${home.server}/submit`);
    await page.getByRole('button', { name: 'Withdraw 1' }).click();
    await page.getByRole('button', { name: 'Withdraw 1 for good?' }).click();
    await page.getByRole('cell', { name: 'withdrawn' }).waitFor();
    await page.getByRole('button', { name: 'Log out' }).click();
    await page.getByLabel("Your team's token").waitFor();
    await page.close();
  });

  it('filter episodes', async () => {
    const page = await openPage(home, '/episodes');
    await page.getByText('1 to 18 of 18').waitFor();
    await page.getByLabel('Words in the instruction').fill('turn LEFT');
    await page.getByText('1 to 6 of 6').waitFor();
    await page.getByRole('link', { name: '1_1' }).click();
    await page.waitForURL(/\/view/);
    await goBack(page);
    await page.getByText('1 to 6 of 6').waitFor(); // the filters are still there
    expect(await page.getByLabel('Words in the instruction').inputValue()).toBe('turn LEFT');
    await page.getByLabel('Words in the instruction').fill('no such words');
    await page.getByRole('heading', { name: 'No episode matches' }).waitFor();
    await inspect(page, 'episodes-empty');
    await page.getByRole('button', { name: 'Clear the filters' }).click();
    await page.getByText('1 to 18 of 18').waitFor();
    await goBack(page);
    await page.getByRole('heading', { name: 'No episode matches' }).waitFor();
    await page.close();
  });

  it('sort episodes by the error of an agent', async () => {
    const page = await openPage(home, '/episodes');
    const walks = JSON.parse(await results(home, false)) as { instr_id: string; trajectory: unknown[] }[];
    const right = JSON.parse(await results(home, true)) as typeof walks;
    const mixed = [right[0], ...walks.slice(1, -1)]; // one at its goal, one not there, the others at their start
    await page.getByLabel('Results file').setInputFiles({ name: 'r.json', mimeType: 'application/json', buffer: Buffer.from(JSON.stringify(mixed)) });
    await page.getByText('17 walks').waitFor();
    await page.getByLabel('Sort by').selectOption('error-up');
    const first = page.locator('tbody tr').first();
    await expect.poll(() => first.textContent(), { timeout: patience }).toContain('0.0 success');
    expect(await first.textContent()).toContain(right[0]!.instr_id);
    expect(await page.locator('tbody tr').last().textContent()).toContain('no trajectory');
    const errors = (await page.locator('tbody tr td:nth-child(3)').allTextContents()).map(Number.parseFloat).filter(Number.isFinite);
    expect(errors.length).toBe(17);
    expect(errors).toEqual([...errors].sort((a, b) => a - b));
    await inspect(page, 'episodes-errors');
    await page.getByLabel('Outcome').selectOption('missing');
    await page.getByText('1 to 1 of 1').waitFor();
    await page.getByRole('button', { name: 'Remove' }).click();
    await page.getByText('1 to 18 of 18').waitFor();
    await page.close();
  });

  it("show an agent's walk beside the reference", async () => {
    const page = await openPage(home, '/episodes');
    const content = await results(home, false);
    const members = Buffer.concat([gzipSync(content.slice(0, 99)), gzipSync(content.slice(99)), Buffer.alloc(512)]);
    await page.getByLabel('Results file').setInputFiles({ name: 'r.json.gz', mimeType: 'application/gzip', buffer: members });
    await page.getByText('18 walks').waitFor();
    await page.getByRole('link', { name: '1_0' }).click();
    await page.waitForURL(/\/view/);
    await page.getByText('no success').waitFor();
    expect(await page.locator('.enfilade-map .walk').count()).toBe(1);
    await inspect(page, 'view-walk');
    await page.close();
  });

  it('correct a graph, in the file that the program applies', async () => {
    const page = await openPage(home, '/verify#home0001');
    await page.getByLabel('Your name').fill('Ada');
    await page.getByRole('button', { name: /^Remove the edge/ }).first().click();
    await page.getByText('Write your name, and the reason.').waitFor();
    await page.getByLabel('Reason').fill('a rope');
    const removed = page.getByRole('button', { name: /^Remove the edge/ });
    const before = await removed.count();
    await removed.first().click();
    await page.getByText('remove-edge').waitFor();
    expect(await removed.count()).toBe(before - 1);
    await page.reload(); // nothing is lost
    await page.getByText('remove-edge').waitFor();
    await page.getByRole('button', { name: 'Undo correction 1' }).click();
    await page.getByText('None yet.').waitFor();
    await page.getByLabel('Reason').fill('a rope');
    await removed.first().click();
    await inspect(page, 'verify-corrected');
    const folder = join(home.folder, '..', 'corrections');
    const corrections = await download(page.getByRole('button', { name: 'Download the corrections' }), folder);
    expect(basename(corrections)).toBe('home0001_corrections.json');
    const [graph, edge] = [join(home.folder, 'connectivity/home0001_connectivity.json'),
      JSON.parse(readFileSync(corrections, 'utf8')).corrections[0]];
    const joined = () => {
      const entries = JSON.parse(readFileSync(graph, 'utf8')) as { image_id: string; unobstructed: boolean[] }[];
      const at = (id: string) => entries.findIndex((entry) => entry.image_id === id);
      return entries[at(edge.from)]!.unobstructed[at(edge.to)];
    };
    expect(joined()).toBe(true);
    makeHomes(home.folder, ['--corrections', folder]);
    expect(joined()).toBe(false);
    await page.close();
  });

  it('show a building at once, and then all around', async () => {
    const page = await openPage(home, '/leaderboard'); // the browser and the server are awake
    await page.getByRole('heading', { name: 'Leaderboard' }).waitFor();
    await page.goto(home.server);
    await page.locator('.hero .box').waitFor();
    const firstPaint = () => page.evaluate(() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0);
    await expect.poll(firstPaint, { timeout: patience }).toBeGreaterThan(0);
    const painted = await firstPaint();
    console.log(`The first view stood after ${Math.round(painted)} ms`);
    // Neither three.js nor anything else that is heavy.
    const scripts = await page.evaluate(() => (performance.getEntriesByType('resource') as PerformanceResourceTiming[])
      .filter(({ name }) => name.endsWith('.js')).reduce((sum, { encodedBodySize }) => sum + encodedBodySize, 0));
    expect(scripts).toBeLessThan(30_000);
    // To and fro within 120 degrees: the last turn of each keyframe is the one from the look.
    await begun(page);
    const turns = await page.evaluate(() => document.getAnimations()
      .flatMap(({ effect }) => (effect instanceof KeyframeEffect ? effect.getKeyframes() : []))
      .flatMap(({ transform }) => [...String(transform ?? '').matchAll(/rotateY\((-?[\d.]+)rad\)/g)].slice(1).map(([, radians]) => Number(radians))));
    expect(turns.length).toBeGreaterThan(20);
    expect(turns[0]).toBeCloseTo(0, 4);
    expect(Math.max(...turns) - Math.min(...turns)).toBeGreaterThan(0.3);
    expect(Math.max(...turns.map(Math.abs))).toBeLessThanOrEqual(Math.PI / 3 + 1e-4);
    await page.getByRole('button', { name: 'Pause' }).click();
    await page.getByRole('button', { name: 'Turn' }).waitFor();
    expect(await differenceFromStill(page)).toBeLessThan(6); // levels of 255: other filters, other edges
    if (!isFirefox) { // WebDriver BiDi cannot ask for less motion
      await page.emulateMedia({ reducedMotion: 'reduce' });
      await page.reload();
      await page.locator('.hero img').waitFor();
      await page.waitForLoadState('networkidle');
      expect(await page.locator('.hero .box').count()).toBe(0);
    }
    await page.close();
  });

  it('begin the exploration where the picture is, looking as it does', async () => {
    const outlook = await (await fetch(`${home.server}/api/v1/scans/${scan}/outlook`)).json() as { viewpoint: string; heading: number };
    const page = await openPage(home, '/');
    await page.locator('.hero .box').waitFor();
    await begun(page);
    await page.getByRole('button', { name: 'Pause' }).click();
    const seconds = 3;
    await page.evaluate((at) => { for (const animation of document.getAnimations()) animation.currentTime = at; }, seconds * 1000);
    await page.getByRole('link', { name: 'Explore from here' }).click();
    await page.waitForFunction(() => window.enfilade !== undefined);
    const pose = await page.evaluate(() => {
      const { viewer } = window.enfilade!;
      return { id: viewer.scan.viewpoints[viewer.pose.viewpoint]!.id, heading: viewer.pose.heading };
    });
    expect(pose.id).toBe(outlook.viewpoint);
    const turned = Math.abs(Math.atan2(Math.sin(pose.heading - outlook.heading), Math.cos(pose.heading - outlook.heading)));
    expect(turned).toBeGreaterThan(0.02); // it had turned
    expect(turned).toBeLessThan(0.1 * seconds);
    await page.close();
  });

  it('offer what can be done, and let no words lie over the picture', async () => {
    const page = await openPage(home, '/');
    for (const [name, href] of [
      ['Follow an instruction', '/try'], ['Play as a model', '/play'], ['Runs of models', '/replay'], ['Leaderboard', '/leaderboard'],
    ] as const) {
      expect(await page.getByRole('list', { name: 'What you can do here' }).getByRole('link', { name }).getAttribute('href')).toBe(href);
    }
    for (const width of [1440, 800, 390]) {
      await page.setViewportSize({ width, height: 900 });
      const [picture, words] = [(await page.locator('.hero .scene').boundingBox())!, (await page.locator('.hero .plate').boundingBox())!];
      expect(words.x + words.width <= picture.x + 1 || words.y >= picture.y + picture.height - 1, `${width} pixels`).toBe(true);
      expect(picture.width).toBeGreaterThan(width * 0.4);
    }
    // Two homes and four fill their rows.
    await page.setViewportSize({ width: 1440, height: 900 });
    for (const count of [2, 4]) {
      const right = await page.evaluate((n) => {
        const list = document.querySelector('.cards')!;
        while (list.children.length < n) list.append(list.firstElementChild!.cloneNode(true));
        return [...list.children].map((card) => Math.round(list.getBoundingClientRect().right - card.getBoundingClientRect().right));
      }, count);
      expect(Math.abs(right[1]!)).toBeLessThan(2);
      expect(Math.abs(right.at(-1)!)).toBeLessThan(2);
    }
    await page.close();
  });

  it('let a visitor follow an instruction', async () => {
    const page = await openPage(home, '/');
    await page.getByRole('link', { name: 'Follow an instruction' }).click();
    await page.getByRole('button', { name: 'Stop here' }).waitFor();
    expect(new URL(page.url()).searchParams.get('split')).toBe('val_seen'); // any episode, kept in the address
    await page.goto(`${home.server}/try?split=val_seen&id=1_0`);
    await page.waitForFunction(() => window.walker !== undefined);
    const answer = await fetch(`${home.server}/api/v1/splits/val_seen/episodes?id=1_0`);
    const { episodes: [episode] } = (await answer.json()) as { episodes: { path: string[] }[] };
    await page.evaluate(async (path) => {
      const { viewer } = window.walker!;
      for (const id of path.slice(1)) {
        const next = viewer.scan.viewpoints.findIndex((viewpoint) => viewpoint.id === id);
        const [from, to] = [viewer.scan.viewpoints[viewer.pose.viewpoint]!.position, viewer.scan.viewpoints[next]!.position];
        viewer.look(Math.atan2(to[0] - from[0], to[1] - from[1]), 0);
        if (!(await viewer.go(next))) throw new Error(`there is no way to ${id}`);
      }
    }, episode!.path);
    await page.getByRole('button', { name: 'Stop here' }).click();
    await page.getByText('stopped 0.0 m from the goal').waitFor();
    expect(await page.locator('.enfilade-map .walk').count()).toBe(1);
    await inspect(page, 'try-done');
    await page.reload();
    await page.getByRole('button', { name: 'Stop here' }).click();
    await page.getByText('You walked 0.0 m').waitFor();
    await page.close();
  });

  it('have a page where there is nothing, and none of styles', async () => {
    const page = await openPage(home, '/nothing');
    await page.getByRole('heading', { name: 'There is nothing here' }).waitFor();
    await inspect(page, 'nothing');
    expect((await page.goto(`${home.server}/styles`))?.status()).toBe(404);
    await page.close();
  });

  it('have one style sheet, all of which a page shows to developers', async () => {
    const vite = await createServer({
      root: pagesFolder, configFile: configFile, server: { port: 0, proxy: { '/api': home.server } }, logLevel: 'error',
    });
    await vite.listen();
    const page = await home.browser.newPage();
    page.setDefaultTimeout(patience);
    await page.goto(`${vite.resolvedUrls!.local[0]}styles`);
    await page.getByRole('heading', { name: 'Styles' }).waitFor();
    await inspect(page, 'styles');
    await page.close();
    await vite.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
