/** A person plays an episode as a language model does: by keys, with pictures, over a reload, to its outcome. */
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Episode } from '../src/episodes/episode.ts';
import { judge, outcomeText } from '../src/episodes/outcome.ts';
import { viewpointIndex } from '../src/scan/scan.ts';
import { Api } from '../src/server/api.ts';
import { download } from './browsers.ts';
import {
  complaints, enfilade, type Home, inspect, missing, newData, openPage, patience, serve, writeHiddenSplit,
} from './harness.ts';

interface Result { readonly instr_id: string; readonly trajectory: readonly (readonly [string, number, number])[] }

const address = (episode: string, view = 'text') => `/play?task=r2r&split=val_seen&episode=${episode}&view=${view}`;
const begun = (page: Page) => page.locator('.play-places li').first().waitFor();
const stepsAre = (page: Page, steps: number) => page.locator('dl.facts div', { hasText: 'Steps' }).getByText(String(steps), { exact: true }).waitFor();
const placeNames = (page: Page) => page.locator('.play-places button').allTextContents();

/** An episode of R2R-Back, beside those of R2R: to the end of the first path, and back. */
function writeBack(data: string): void {
  const [first] = JSON.parse(readFileSync(join(data, 'r2r/R2R_val_seen.json'), 'utf8')) as { path: string[] }[];
  const { path } = first!;
  mkdirSync(join(data, 'r2r-back'), { recursive: true });
  writeFileSync(join(data, 'r2r-back/R2R_val_seen.json'), JSON.stringify([{
    ...first, path: [...path, ...path.slice(0, -1).reverse()], midstop: path.at(-1), instructions: ['Go there and come back.'],
  }]));
}

describe.skipIf(missing)('who plays an episode', () => {
  let home: Home;
  let folder: string;
  let first: readonly Result[];

  beforeAll(async () => {
    const made = newData();
    folder = made.folder;
    const { data } = made;
    writeBack(data);
    writeHiddenSplit(data);
    enfilade('ask', '--data', data, '--split', 'val_seen', '--stand-in', 'first', '--steps', '6', '-o', join(folder, 'first'));
    first = JSON.parse(readFileSync(join(folder, 'first/results.json'), 'utf8')) as Result[];
    home = await serve(folder, data, join(folder, 'service.sqlite'));
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('walks what the rule "first" walks, by keys alone, and saves it', async () => {
    const page = await openPage(home, address('1_0'));
    await begun(page);
    await inspect(page, 'play-text');
    for (let step = 1; step <= 6; ++step) {
      await page.keyboard.press((await placeNames(page))[0]!.toLowerCase());
      await stepsAre(page, step);
    }
    await page.getByRole('button', { name: 'Stop here' }).focus();
    await page.keyboard.press('Enter');
    await page.keyboard.press('Enter');
    await page.getByText('You stopped after 7 steps, no mistake.').waitFor();
    await inspect(page, 'play-over');
    expect(await page.getByRole('link', { name: 'Show the reference path' }).getAttribute('href')).toBe('/view?split=val_seen&id=1_0');
    const [saved] = JSON.parse(readFileSync(await download(page.getByRole('link', { name: 'Save the result' }), join(folder, 'saved')), 'utf8')) as Result[];
    expect(saved).toEqual(first.find(({ instr_id }) => instr_id === '1_0'));
    // The outcome is the server's, and what /try would say of the same trajectory.
    const api = new Api(home.server);
    const [scan, { episodes: [episode] }] = await Promise.all([
      api.scan('home0001'), api.call<{ episodes: Episode[] }>('splits/val_seen/episodes?id=1_0')]);
    const walk = saved!.trajectory.map(([id]) => viewpointIndex(scan, id)).filter((v, k, all) => v !== all[k - 1]);
    const outcome = judge(scan, episode!, walk)!;
    await page.getByText(outcomeText(outcome)).waitFor();
    await page.getByRole('heading', { name: outcome.success ? /^Success/ : /^No success/ }).waitFor();
    const points = async (line: string) => (await page.locator(`.enfilade-map .${line}`).getAttribute('points'))!.split(' ');
    expect(await points('path')).toHaveLength(3);
    expect(await points('walk')).toHaveLength(walk.length);
    await page.reload(); // it is still there
    await page.getByText(outcomeText(outcome)).waitFor();
    await page.close();
  });

  it('is told nothing of a hidden goal', async () => {
    const page = await openPage(home, '/play?split=test&episode=9_0');
    await begun(page);
    await page.getByRole('button', { name: 'Stop here' }).press('Enter');
    await page.keyboard.press('Enter');
    await page.getByRole('heading', { name: 'The episode is over' }).waitFor();
    await page.getByText('You stopped after 1 step, no mistake.').waitFor();
    expect(await page.locator('.enfilade-map').count()).toBe(0);
    expect(await page.getByRole('link', { name: 'Show the reference path' }).count()).toBe(0);
    await page.close();
  });

  it('says where the way back begins', async () => {
    const page = await openPage(home, '/play?task=r2r-back&split=val_seen&episode=1_0&view=text');
    await begun(page);
    await page.keyboard.press((await placeNames(page))[0]!.toLowerCase());
    await stepsAre(page, 1);
    await page.getByRole('button', { name: 'The way back begins here' }).press('Enter');
    await page.getByText(/^You said that the way back begins at [A-Z]+\.$/).waitFor();
    await page.getByRole('button', { name: 'Stop here' }).press('Enter');
    await page.keyboard.press('Enter');
    const saved = readFileSync(await download(page.getByRole('link', { name: 'Save the result' }), join(folder, 'saved-back')), 'utf8');
    const [{ midstop, trajectory }] = JSON.parse(saved) as [Result & { midstop: string }];
    expect(midstop).toBe(trajectory.at(-1)![0]);
    await page.close();
  });

  it('sees the places marked in a picture, and goes on after a reload', async () => {
    const page = await openPage(home, address('2_0', 'marks'));
    await begun(page);
    await page.getByRole('img', { name: /^Left, ahead, right and behind/ }).waitFor();
    const picture = page.locator('.play-strip img').first();
    await expect.poll(() => picture.evaluate((image) => (image as HTMLImageElement).naturalWidth)).toBe(4 * 384);
    await inspect(page, 'play-marks');
    const before = await picture.getAttribute('src');
    await page.keyboard.press('ArrowLeft');
    await page.getByText('You look left.').waitFor();
    await expect.poll(() => picture.getAttribute('src')).not.toBe(before);
    expect(page.url()).not.toContain('play_');
    expect(await page.locator('html').innerHTML()).not.toContain('play_');
    const names = await placeNames(page);
    await page.reload();
    await stepsAre(page, 1);
    await page.getByText('You look left.').waitFor();
    expect(await placeNames(page)).toEqual(names);
    await page.close();
  });

  it('uses each tool by its button, and leaves the letters to those who type', async () => {
    const page = await openPage(home, address('1_1'));
    await begun(page);
    expect(await page.locator('.instruction').textContent()).toBe('<img src=x onerror=alert(1)> Turn left.');
    await page.getByRole('button', { name: 'Look behind' }).click();
    await page.getByText('You look behind.').waitFor();
    await page.getByRole('button', { name: /^Go to B/ }).click();
    await page.getByText('You went to B').waitFor();
    await page.getByRole('button', { name: 'Go back to A' }).click();
    await page.getByText('You went to A').waitFor();
    await page.getByText('visited', { exact: true }).first().waitFor();
    await page.getByLabel('Keys').uncheck();
    await page.keyboard.press('b');
    await page.waitForTimeout(300);
    await stepsAre(page, 3);
    await page.getByRole('button', { name: 'Stop here' }).click();
    await page.getByRole('button', { name: 'Stop for good?' }).click();
    await page.getByText(/^You stopped after 4 steps/).waitFor();
    await page.getByRole('button', { name: 'Play it again' }).click();
    await stepsAre(page, 0);
    await page.close();
  });

  it('chooses an episode by a form', async () => {
    const page = await openPage(home, '/play');
    await page.getByLabel('Split').waitFor();
    await inspect(page, 'play-begin');
    await page.getByLabel('Observations').selectOption('marks');
    await page.getByRole('button', { name: 'Begin' }).click();
    await page.waitForURL(/split=val_seen&episode=\d_\d&view=marks/);
    await begun(page);
    await page.goto(home.server + address('77_0'));
    expect(await page.getByRole('alert').textContent()).toContain('no episode');
    await page.getByRole('link', { name: 'Choose another episode' }).click();
    await page.getByLabel('Observations').waitFor();
    await page.close();
  });

  it('gets an episode of the benchmark, split and view that the address names', async () => {
    const page = await openPage(home, '/play?task=r2r-back&split=val_seen&view=marks');
    await begun(page);
    expect(Object.fromEntries(new URL(page.url()).searchParams)).toEqual({ task: 'r2r-back', split: 'val_seen', episode: '1_0', view: 'marks' });
    await page.getByRole('img', { name: /^Left, ahead, right and behind/ }).waitFor();
    await page.getByText('Go there and come back.').waitFor();
    await page.goto(`${home.server}/play?task=r2r-back&view=marks`); // which split it is about is to be chosen
    await page.getByLabel('Observations').waitFor();
    expect(await page.getByLabel('Split').inputValue()).toBe('r2r-back/val_seen');
    expect(await page.getByLabel('Observations').inputValue()).toBe('marks');
    await page.goto(`${home.server}/play?split=nowhere`);
    expect(await page.getByRole('alert').textContent()).toContain('no split nowhere');
    await page.close();
  });

  it('has all four views on a phone, and no switch for keys', async () => {
    const page = await openPage(home, address('3_0', 'marks'), true);
    await begun(page);
    const halves = page.locator('.play-strip > div');
    await halves.first().waitFor();
    const width = () => page.locator('.play-strip img').first().evaluate((image) => (image as HTMLImageElement).naturalWidth);
    await expect.poll(width, { timeout: patience }).toBe(4 * 384);
    const [above, below] = [(await halves.nth(0).boundingBox())!, (await halves.nth(1).boundingBox())!];
    expect(below.y).toBeGreaterThanOrEqual(above.y + above.height);
    for (const box of [above, below]) {
      expect(box.x).toBeGreaterThanOrEqual(0);
      expect(box.x + box.width).toBeLessThanOrEqual(390);
      expect(box.width / box.height).toBeCloseTo(2, 1);
    }
    // Each shows its half of the picture.
    const lefts = await page.locator('.play-strip img').evaluateAll((images) =>
      images.map((image) => image.getBoundingClientRect().left - image.parentElement!.getBoundingClientRect().left));
    expect(lefts.map((left) => Math.round(left / above.width))).toEqual([0, -1]);
    expect(await page.getByLabel('Keys').isVisible()).toBe(false);
    await page.close();
  });

  it('can save the result where the map of the outcome does not come', async () => {
    const page = await openPage(home, address('4_0'));
    await begun(page);
    await page.route('**/api/v1/scans/home0001', (route) =>
      route.fulfill({ status: 500, json: { error: { code: 'internal', message: 'The building cannot be read' } } }));
    await page.getByRole('button', { name: 'Stop here' }).click();
    await page.getByRole('button', { name: 'Stop for good?' }).click();
    await page.getByText('The building cannot be read').waitFor();
    await page.getByRole('heading', { name: 'The episode is over' }).waitFor();
    await page.getByRole('link', { name: 'Save the result' }).waitFor();
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
