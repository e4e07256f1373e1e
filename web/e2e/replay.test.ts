/** Runs of the arena: tables with their measures, steps with what the model saw, two runs compared, markup in what models say. */
import { readFileSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Viewer } from '../src/viewer/viewer.ts';
import { download, isFirefox } from './browsers.ts';
import {
  complaints, enfilade, type Home, inspect, missing, newData, newFolder, openPage, patience, serve, writeHiddenSplit,
} from './harness.ts';

declare const window: { replay?: { step: number; viewers: (Viewer | undefined)[] }; hurt?: boolean };

const markup = '<script>window.hurt = true</script><img src=x onerror="window.hurt = true"> B is the <b>door</b>.';

const shown = (page: Page, step: number) => page.waitForFunction(
  (wanted) => window.replay?.step === wanted, step, { timeout: patience });
/** Where each run's picture stands: ids. */
const standing = (page: Page) => page.evaluate(() => window.replay!.viewers.map((viewer) => viewer && viewer.scan.viewpoints[viewer.pose.viewpoint]!.id));
const standsAt = async (page: Page, ...ids: string[]): Promise<void> => {
  await expect.poll(() => standing(page), { timeout: patience }).toEqual(ids);
};
const headingOf = (page: Page) => page.evaluate(() => window.replay!.viewers[0]!.pose.heading);

/** The answer for an episode of a run, as the server gives it. */
interface Answer {
  readonly steps: {
    at: { viewpoint: string; heading: number };
    call: { tool: string; argument: string };
    observation: { heading: number; places: { name: string; turn: number }[] };
    pictures?: string[];
  }[];
  readonly end: { at: { viewpoint: string } };
  readonly outcome: { success: boolean; error: number; path: string[] };
}

/** How a GIF is built: its size, and for how long each picture stands, hundredths of a second. */
function readGif(bytes: Buffer): { width: number; height: number; delays: number[] } {
  expect(bytes.subarray(0, 6).toString('latin1')).toBe('GIF89a');
  const delays: number[] = [];
  let [at, images] = [13, 0];
  const skipBlocks = () => {
    for (let size = bytes[at++]!; size > 0; size = bytes[at++]!) at += size;
  };
  while (bytes[at] !== 0x3b) {
    const kind = bytes[at++];
    if (kind === 0x21) {
      if (bytes[at++] === 0xf9) delays.push(bytes.readUInt16LE(at + 2));
      skipBlocks();
    } else {
      expect(kind).toBe(0x2c);
      at += 9 + 3 * 256 + 1; // its place, its own colours, the least size of codes
      skipBlocks();
      ++images;
    }
  }
  expect(at).toBe(bytes.length - 1);
  expect(images).toBe(delays.length);
  return { width: bytes.readUInt16LE(6), height: bytes.readUInt16LE(8), delays };
}

describe.skipIf(missing)('runs', () => {
  let home: Home;
  let walked: string[];
  let runs: string;
  const answer = async (run: string): Promise<Answer> => (await fetch(`${home.server}/api/v1/runs/${run}/episodes/1_0`)).json() as Promise<Answer>;

  beforeAll(async () => {
    const { folder, data } = newData();
    runs = join(folder, 'runs');
    writeHiddenSplit(data);
    const ask = (name: string, split: string, rule: string, ...more: readonly string[]) =>
      enfilade('ask', '--data', data, '--split', split, '--stand-in', rule, '-o', join(runs, name), ...more);
    for (const rule of ['oracle', 'random', 'first']) ask(rule, 'val_seen', rule);
    ask('marks', 'val_seen', 'oracle', '--prompt', 'marks', '--picture-size', '256');
    ask('secret', 'test', 'first');
    // What a model might say, at the first step.
    const file = join(runs, 'oracle/transcripts/1_1.jsonl');
    const [head, first, ...rest] = readFileSync(file, 'utf8').split('\n');
    writeFileSync(file, [head, JSON.stringify({ ...(JSON.parse(first!) as object), text: markup }), ...rest].join('\n'));
    writeFileSync(join(runs, 'random/transcripts/2_0.jsonl'), `${head}\n`);
    home = await serve(folder, data, join(folder, 'service.sqlite'), ['--runs', runs]);
  });
  afterAll(async () => {
    await home?.stop();
  });

  /** The server's answer of a run's list or measures. */
  const asked = async <T>(path: string): Promise<T> => (await fetch(`${home.server}/api/v1/runs${path}`)).json() as Promise<T>;
  const episodesShown = (page: Page) => page.locator('tbody tr > td:first-child').allTextContents();

  it('are listed with their measures, sorted by any of them', async () => {
    const page = await openPage(home, '/');
    await page.getByRole('link', { name: 'Runs', exact: true }).click();
    await page.getByRole('cell', { name: 'oracle', exact: true }).waitFor();
    const { scores } = await asked<{ scores: { short: string; mean: number }[] }>('/oracle/measures');
    const sr = (100 * scores.find(({ short }) => short === 'SR')!.mean).toFixed(1);
    const row = page.getByRole('row', { name: /^oracle / });
    await expect.poll(() => row.textContent(), { timeout: patience }).toContain(sr);
    expect(await page.getByRole('row', { name: /^secret / }).textContent()).toContain('–'); // nothing is said of success
    await inspect(page, 'replay-runs');
    await page.getByRole('button', { name: 'SR', exact: true }).click();
    await page.waitForURL(/sort=SR$/);
    await page.getByRole('button', { name: 'SR', exact: true }).click();
    await page.waitForURL(/sort=SR-ascending/);
    const names = await episodesShown(page);
    await page.reload();
    await page.getByRole('cell', { name: 'oracle', exact: true }).waitFor();
    await expect.poll(() => episodesShown(page), { timeout: patience }).toEqual(names);
    expect(names.at(-1)).toBe('secret');
    await page.close();
  });

  it('have a page of their episodes, with the failures by themselves', async () => {
    const page = await openPage(home, '/replay?run=random');
    await page.getByRole('heading', { name: 'random' }).waitFor();
    await page.getByText('val_seen, model stand-in-random, prompt text').waitFor();
    await page.getByText('the last line is no end of an episode').waitFor();
    await inspect(page, 'replay-episodes');
    type List = { list: { episode: string; steps?: number; nav_error: number }[] };
    const failuresOf = async (run: string) => ({ run, ...(await asked<List>(`/${run}?show=failures`)) });
    const runsWithFailures = await Promise.all(['first', 'random', 'oracle'].map(failuresOf));
    const { run, list } = runsWithFailures.find((one) => one.list.length > 0)!;
    await page.goto(`${home.server}/replay?run=${run}`);
    await page.getByLabel('Show').selectOption('failures');
    await page.waitForURL(/show=failures/);
    await expect.poll(() => episodesShown(page), { timeout: patience }).toEqual(list.map(({ episode }) => episode));
    await page.getByRole('button', { name: 'Steps' }).click();
    await page.waitForURL(/sort=steps/);
    const bySteps = await asked<List>(`/${run}?show=failures&sort=steps&descending=1`);
    await expect.poll(() => episodesShown(page), { timeout: patience }).toEqual(bySteps.list.map(({ episode }) => episode));
    await page.reload(); // the address has both
    await expect.poll(() => episodesShown(page), { timeout: patience }).toEqual(bySteps.list.map(({ episode }) => episode));
    expect(await page.getByLabel('Show').inputValue()).toBe('failures');
    expect(await page.locator('tbody tr').first().textContent()).toContain(`failure${bySteps.list[0]!.nav_error.toFixed(1)} m from the goal`);
    await page.goto(`${home.server}/replay?run=random`);
    await page.getByRole('link', { name: '2_0', exact: true }).click();
    expect(await page.getByRole('alert').textContent()).toContain('transcripts/2_0.jsonl, line 2: the end is missing');
    await inspect(page, 'replay-broken');
    await page.close();
  });

  it('say nothing of success where goals are hidden', async () => {
    const page = await openPage(home, '/replay?run=secret');
    await page.getByRole('link', { name: '9_0', exact: true }).waitFor();
    expect(await page.getByLabel('Show').locator('option').allTextContents()).toEqual(['All episodes', 'With a mistake', 'Without a stop']);
    expect(await page.locator('main').textContent()).not.toMatch(/success|failure|\bSPL\b|from the goal/i);
    await page.getByRole('link', { name: '9_0', exact: true }).click();
    await shown(page, 1);
    await page.getByLabel('Step', { exact: true }).press('End');
    await page.getByRole('heading', { name: 'The end' }).waitFor();
    expect(await page.locator('main').textContent()).not.toMatch(/success|failure|\bSPL\b|from the goal/i);
    expect(await page.locator('.enfilade-map .path').first().getAttribute('points')).toBe('');
    await page.close();
  });

  it('lead back where there is no such run, and say how to make one where there is none', async () => {
    const page = await openPage(home, '/replay?run=nosuch');
    await page.getByText('There is no run "nosuch"').waitFor();
    await page.getByRole('link', { name: 'Go to Runs' }).click();
    await page.getByRole('cell', { name: 'oracle', exact: true }).waitFor();
    await page.route('**/api/v1/runs', (route) => route.fulfill({ json: { runs: [] } }));
    await page.reload();
    await page.getByText('enfilade ask --data DATA --stand-in oracle').waitFor();
    await inspect(page, 'replay-no-runs');
    await page.close();
  });

  it('are shown step by step, each with its place, its map and its words', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0');
    await shown(page, 1);
    const { steps, end, outcome } = await answer('oracle');
    // What the walk of the transcript comes to, the results file says by itself.
    const results = JSON.parse(readFileSync(join(runs, 'oracle/results.json'), 'utf8')) as { instr_id: string; trajectory: [string][] }[];
    walked = results.find(({ instr_id }) => instr_id === '1_0')!.trajectory.map(([id]) => id);
    expect(steps.map(({ at }) => at.viewpoint)).toEqual(walked);
    await standsAt(page, walked[0]!);
    const { call: { argument }, observation: { heading, places } } = steps[0]!;
    expect(await page.locator('.replay-call').textContent()).toBe(`go_to ${argument}`);
    const there = ((heading + places.find(({ name }) => name === argument)!.turn) * Math.PI) / 180;
    await page.evaluate((to) => window.replay!.viewers[0]!.look(to, 0), there); // the mark may have been beside the picture
    await page.locator('.enfilade-goal-lines text', { hasText: `${argument}: goes here` }).waitFor({ state: 'attached' });
    for (let k = 1; k < steps.length; ++k) {
      await page.getByRole('button', { name: 'Next' }).click();
      await shown(page, k + 1);
      await standsAt(page, steps[k]!.at.viewpoint);
      expect(await headingOf(page)).toBeCloseTo((steps[k]!.at.heading * Math.PI) / 180, 3);
    }
    await page.getByText(`Step ${steps.length} of ${steps.length}`).waitFor();
    expect((await page.locator('.enfilade-map .walk').first().getAttribute('points'))!.split(' ')).toHaveLength(walked.length);
    await inspect(page, 'replay-step');
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByText(`It stopped after ${steps.length} steps, no mistake.`).waitFor();
    await standsAt(page, end.at.viewpoint);
    // What came of it, in words and on the map.
    await page.getByText(`It stopped ${outcome.error.toFixed(1)} m from the goal: success`).waitFor();
    expect((await page.locator('.enfilade-map .path').first().getAttribute('points'))!.split(' ')).toHaveLength(outcome.path.length);
    await inspect(page, 'replay-end');
    await page.getByText('More', { exact: true }).click();
    expect(await page.getByRole('link', { name: 'Episode', exact: true }).getAttribute('href')).toBe('/view?split=val_seen&id=1_0');
    await page.getByRole('button', { name: /^go_to/ }).first().click();
    await shown(page, 1);
    await page.close();
  });

  it('have an address for each step', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0#2');
    await shown(page, 2);
    await standsAt(page, walked[1]!);
    await page.getByRole('button', { name: 'Next' }).click();
    await shown(page, 3);
    expect(new URL(page.url()).hash).toBe('#3');
    if (!isFirefox) await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    await page.getByRole('button', { name: 'Copy link' }).click();
    const copied = isFirefox ? page.url() : await page.evaluate(() => navigator.clipboard.readText());
    const other = await openPage(home, copied.slice(home.server.length));
    await shown(other, 3);
    await standsAt(other, walked[2]!);
    await other.evaluate(() => { location.hash = '#1'; });
    await shown(other, 1);
    await other.goto(`${home.server}/replay?run=oracle&episode=1_0#99999`);
    await shown(other, walked.length + 1); // the end
    await other.close();
    await page.close();
  });

  it('of the same episode stand side by side', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0#2');
    await shown(page, 2);
    await page.getByText('More', { exact: true }).click();
    await page.getByLabel('Compare with').selectOption('random');
    await page.waitForURL(/with=random/);
    await shown(page, 2);
    const [left, right] = [await answer('oracle'), await answer('random')];
    await standsAt(page, left.steps[1]!.at.viewpoint, right.steps[1]!.at.viewpoint);
    await inspect(page, 'replay-two');
    await page.getByLabel('Step', { exact: true }).press('End'); // the longer one's end
    await shown(page, Math.max(left.steps.length, right.steps.length) + 1);
    await standsAt(page, left.end.at.viewpoint, right.end.at.viewpoint);
    expect(await page.getByText('The end', { exact: true }).count()).toBeGreaterThanOrEqual(2);
    await page.close();
  });

  it('show exactly what the model saw, and an arrow to a place out of sight', async () => {
    const page = await openPage(home, '/replay?run=marks&episode=1_0');
    await shown(page, 1);
    const { steps } = await answer('marks');
    const strip = page.locator('.replay-strip img');
    for (let k = 0; k < steps.length; ++k) {
      await shown(page, k + 1);
      expect(steps[k]!.pictures).toEqual(['']);
      await expect.poll(() => strip.first().getAttribute('src'), { timeout: patience })
        .toBe(`/api/v1/runs/marks/episodes/1_0/steps/${k + 1}/pictures/0`);
      const sizes = () => strip.evaluateAll((all) =>
        (all as HTMLImageElement[]).map(({ naturalWidth, naturalHeight }) => [naturalWidth, naturalHeight]));
      await expect.poll(sizes, { timeout: patience }).toEqual([[1024, 256], [1024, 256]]);
      const { call, observation: { places } } = steps[k]!;
      expect(await strip.first().getAttribute('alt')).toContain(places.map(({ name }) => name).join(', '));
      const chosen = places.find(({ name }) => call.tool === 'go_to' && name === call.argument);
      const half = await page.evaluate(() => {
        const { width, height, vfov } = window.replay!.viewers[0]!.view;
        return (Math.atan(Math.tan(vfov / 2) * (width / height)) * 180) / Math.PI;
      });
      await expect.poll(() => page.locator('.enfilade-next').isVisible(), { timeout: patience, message: `step ${k + 1}` })
        .toBe(chosen !== undefined && Math.abs(chosen.turn) >= half * 0.85);
      if (k === 0) await inspect(page, 'replay-saw');
      await page.getByRole('button', { name: 'Next' }).click();
    }
    await shown(page, steps.length + 1);
    await expect.poll(() => strip.count(), { timeout: patience }).toBe(0);
    await page.close();
  });

  it('play by themselves, and stop when one asks', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0');
    await shown(page, 1);
    await page.getByRole('button', { name: 'Play' }).click();
    await shown(page, 2);
    await page.getByRole('button', { name: 'Pause' }).click();
    await page.getByRole('button', { name: 'Play' }).waitFor();
    await page.getByLabel('Step', { exact: true }).press('End');
    await page.getByRole('button', { name: 'Play' }).click(); // from the beginning
    await shown(page, 1);
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByRole('button', { name: 'Play' }).waitFor();
    await page.close();
  });

  it('begin with the picture, on a desktop and on a phone', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0#2');
    await shown(page, 2);
    expect((await page.locator('.replay-head').boundingBox())!.height).toBeLessThanOrEqual(64);
    await page.close();
    for (const [run, part] of [['oracle', '.replay-view > .view'], ['marks', '.replay-strip']] as const) {
      const phone = await openPage(home, `/replay?run=${run}&episode=1_0#2`, true);
      await shown(phone, 2);
      expect((await phone.locator(part).boundingBox())!.y).toBeLessThan(422);
      await phone.close();
    }
  });

  it('are saved as a film of what the model saw, or of the view', async () => {
    for (const [run, height] of [['marks', 160], ['oracle', 400]] as const) {
      const page = await openPage(home, `/replay?run=${run}&episode=1_0#2`);
      await shown(page, 2);
      await page.getByText('More', { exact: true }).click();
      const saved = await download(page.getByRole('button', { name: 'Save as GIF' }), newFolder());
      expect(basename(saved)).toBe(`${run}_1_0.gif`);
      const gif = readGif(readFileSync(saved));
      const { steps } = await answer(run);
      expect(gif.delays).toEqual([...steps.map(() => 150), 400]);
      expect(gif.width).toBe(640);
      expect(gif.height).toBeGreaterThan(height + 30);
      await page.getByText('Saved:').waitFor();
      await standsAt(page, steps[1]!.at.viewpoint); // the view that was there before
      await page.close();
    }
  });

  it('are compared over the episodes that both have', async () => {
    const page = await openPage(home, '/replay?run=oracle');
    await page.getByLabel('Compare with').selectOption('first');
    await page.waitForURL(/run=oracle&with=first/);
    await page.getByRole('heading', { name: 'oracle and first' }).waitFor();
    type Comparison = { columns: { short: string; first: number; p: number }[]; differing: number; list: { episode: string }[] };
    const { columns, differing, list } = await asked<Comparison>('/oracle/compare/first');
    const sr = columns.find(({ short }) => short === 'SR')!;
    expect(await page.getByRole('row', { name: /^SR/ }).textContent()).toContain((100 * sr.first).toFixed(1));
    await inspect(page, 'replay-compare');
    if (differing > 0) {
      await page.getByRole('link', { name: list[0]!.episode, exact: true }).click();
      await page.waitForURL((url) => url.searchParams.get('with') === 'first' && url.searchParams.get('episode') === list[0]!.episode);
      await shown(page, 1);
      expect(await page.evaluate(() => window.replay!.viewers.length)).toBe(2);
    } else await page.getByText('No difference').waitFor();
    await page.close();
  });

  it('show markup in instructions and thoughts as text', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_1');
    await shown(page, 1);
    await expect.poll(() => page.locator('.replay-thought').textContent()).toBe(markup);
    expect(await page.locator('.instruction').textContent()).toBe('<img src=x onerror=alert(1)> Turn left.');
    expect(await page.locator('main img, main script').count()).toBe(0);
    expect(await page.evaluate(() => window.hurt)).toBeUndefined();
    await page.close();
  });

  it('are walked through by keys alone', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0');
    await shown(page, 1);
    await page.keyboard.press('ArrowRight');
    await shown(page, 2);
    await page.keyboard.press('ArrowLeft');
    await shown(page, 1);
    await page.getByRole('button', { name: 'Next' }).focus();
    await page.keyboard.press('Enter');
    await page.keyboard.press('Enter');
    await shown(page, 3);
    await page.locator('canvas').focus(); // here they look around
    const heading = await headingOf(page);
    await page.keyboard.press('ArrowRight');
    expect(await headingOf(page)).toBeGreaterThan(heading);
    await shown(page, 3);
    await page.close();
  });

  it('say so where the places are not known', async () => {
    const file = join(runs, 'oracle/transcripts/3_0.jsonl');
    writeFileSync(file, readFileSync(file, 'utf8').replace('"distance":', '"distance":9'));
    const page = await openPage(home, '/replay?run=oracle&episode=3_0');
    await shown(page, 1);
    await page.getByText('step 1 comes out differently').waitFor();
    expect(await page.locator('canvas').count()).toBe(0);
    await inspect(page, 'replay-unknown');
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
