/** Runs of the arena, looked at step by step: one, two beside each other, with markup in what models say. */
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Viewer } from '../src/viewer/viewer.ts';
import { isFirefox } from './browsers.ts';
import { complaints, enfilade, type Home, inspect, makeHomes, missing, newFolder, openPage, patience, serve, writeAnnotations } from './harness.ts';

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
  }[];
  readonly end: { at: { viewpoint: string } };
}

describe.skipIf(missing)('runs', () => {
  let home: Home;
  let walked: string[];
  let runs: string;
  const answer = async (run: string): Promise<Answer> => (await fetch(`${home.server}/api/v1/runs/${run}/episodes/1_0`)).json() as Promise<Answer>;

  beforeAll(async () => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    runs = join(folder, 'runs');
    makeHomes(data);
    writeAnnotations(data);
    for (const rule of ['oracle', 'random']) enfilade('ask', '--data', data, '--split', 'val_seen', '--stand-in', rule, '-o', join(runs, rule));
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

  it('are listed with their episodes', async () => {
    const page = await openPage(home, '/');
    await page.getByRole('link', { name: 'Runs' }).click();
    await page.getByRole('cell', { name: 'oracle', exact: true }).waitFor();
    await inspect(page, 'replay-runs');
    await page.getByRole('link', { name: 'random', exact: true }).click();
    await page.getByRole('heading', { name: 'random' }).waitFor();
    await page.getByText('split val_seen').waitFor();
    await page.getByText('the last line is no end of an episode').waitFor();
    await inspect(page, 'replay-episodes');
    await page.getByRole('link', { name: '2_0' }).click();
    expect(await page.getByRole('alert').textContent()).toContain('transcripts/2_0.jsonl, line 2: the end is missing');
    await inspect(page, 'replay-broken');
    await page.close();
  });

  it('are shown step by step, each with its place, its map and its words', async () => {
    const page = await openPage(home, '/replay?run=oracle&episode=1_0');
    await shown(page, 1);
    const { steps, end } = await answer('oracle');
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
    await page.getByText('All steps').click();
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
    await page.getByLabel('Beside').selectOption('random');
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
