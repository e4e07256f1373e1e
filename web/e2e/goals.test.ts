/** Goals of every benchmark in the viewer: objects outlined, regions, dialogues, languages, words in time. */
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Episode } from '../src/episodes/episode.ts';
import { judge, type Outcome } from '../src/episodes/outcome.ts';
import { viewpointIndex } from '../src/scan/scan.ts';
import { Api } from '../src/server/api.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import { complaints, type Home, inspect, makeHomes, missing, newFolder, openPage, patience, serve } from './harness.ts';

declare const window: { enfilade?: { viewer: Viewer } };

interface Entry { readonly image_id: string; readonly unobstructed: readonly boolean[]; readonly included: boolean }

const firstScan = (data: string): string => readFileSync(join(data, 'connectivity/scans.txt'), 'utf8').trim().split(/\s+/)[0]!;

/** A path of three viewpoints, and a fourth beside its end. */
function places(data: string, scan: string): [string, string, string, string] {
  const graph = JSON.parse(readFileSync(join(data, `connectivity/${scan}_connectivity.json`), 'utf8')) as Entry[];
  const next = (k: number) => graph[k]!.unobstructed.flatMap((open, to) => (open && graph[to]!.included ? [to] : []));
  for (const a of graph.keys()) {
    for (const b of next(a)) {
      for (const c of next(b).filter((k) => k !== a)) {
        const d = next(c).find((k) => k !== a && k !== b);
        if (d !== undefined) return [a, b, c, d].map((k) => graph[k]!.image_id) as [string, string, string, string];
      }
    }
  }
  throw new Error('no path of four viewpoints');
}

/** SYNTHETIC files by hand, in the forms of the benchmarks: one episode each. */
function writeGoals(data: string): void {
  const scan = firstScan(data);
  const [start, middle, end, aside] = places(data, scan);
  const write = (name: string, text: string) => {
    mkdirSync(dirname(join(data, name)), { recursive: true });
    writeFileSync(join(data, name), text);
  };
  const common = { scan, heading: 0.5, path: [start, middle, end] };
  const reverie = { ...common, id: '7_57', path_id: 7, objId: 57, instructions: ['Water the <b>plant</b> in the corner.'] };
  write('reverie/REVERIE_val_seen.json', JSON.stringify([reverie]));
  write('reverie/REVERIE_test.json', JSON.stringify([{ scan, heading: 0.5, id: '8', path: [start], instructions: ['Find it.'] }]));
  const plant = { name: 'plant', visible_pos: [12, 13], bbox2d: [[420, 150, 120, 160], [80, 150, 120, 160]] };
  write('reverie/BBoxes.json', JSON.stringify({ [`${scan}_${end}`]: { 57: plant }, [`${scan}_${aside}`]: { 57: plant }, [`${scan}_${start}`]: {} }));
  write('cvdn/val_seen.json', JSON.stringify([{
    inst_idx: 3, scan, target: 'chair', start_pano: { heading: 0.5, elevation: 0, pano: start }, nav_camera: [],
    dialog_history: [{ nav_idx: 0, role: 'navigator', message: 'Left <i>or</i> right?' }, { nav_idx: 2, role: 'oracle', message: 'To the left.' }],
    nav_history: [start], game_idx: 1, end_panos: [end, aside], player_path: [start, middle, end], planner_path: [start, middle],
  }, { // before anything is said
    inst_idx: 4, scan, target: 'chair', start_pano: { heading: 0.5, elevation: 0, pano: start }, nav_camera: [], dialog_history: [],
    nav_history: [start], game_idx: 1, end_panos: [end, aside], player_path: [start, middle, end], planner_path: [start, middle],
  }]));
  const timed = ['जाओ', 'सीधे', 'और', 'रुको'].map((word, k) => ({ word, start_time: 0.5 * k, end_time: 0.5 * k + 0.4 }));
  write('rxr/rxr_val_seen_guide.jsonl', `${JSON.stringify({
    ...common, path_id: 11, split: 'val_seen', instruction_id: 26, annotator_id: 1, language: 'hi-IN',
    instruction: timed.map(({ word }) => word).join(' '), timed_instruction: timed, edit_distance: 0,
  })}\n`);
  const corner = (heading: number, elevation: number) => ({ heading, elevation });
  write('soon/val_seen.json', JSON.stringify([{
    path: [[start, middle, end]], instr_id: '5',
    instructions: [['I want to find the vase. ', 'It is round. ', 'By the wall. ', 'In the hall. ', 'Find the round vase in the hall.']],
    bboxes: [{ scan, image_id: end, heading: 0, elevation: 0, obj_name: 'vase', target: {
      center: corner(0, 0), left_top: corner(6.0, 0.2), right_top: corner(0.25, 0.2),
      right_bottom: corner(0.25, -0.3), left_bottom: corner(6.0, -0.3) } }],
  }]));
  write('r2r-back/R2R_val_seen.json', JSON.stringify([{
    ...common, path_id: 9, path: [start, middle, start], distance: 4, midstop: middle, instructions: ['Go there and come back.'],
  }]));
}

const ready = (page: Page) => page.waitForFunction(() => window.enfilade !== undefined);

describe.skipIf(missing)('goals in the viewer', () => {
  let home: Home;
  let page: Page;

  /** The first episode of a benchmark's split. */
  const open = async (task: string, split = 'val_seen') => {
    const answer = await fetch(`${home.server}/api/v1/splits/${split}/episodes?task=${task}`);
    const id = ((await answer.json()) as { episodes: { instruction_id: string }[] }).episodes[0]!.instruction_id;
    const key = `${task}/${split}`;
    await page.goto(`${home.server}/view?${new URLSearchParams({ split: key, id })}`);
    await ready(page);
  };

  beforeAll(async () => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    makeHomes(data);
    writeGoals(data);
    home = await serve(folder, data, join(folder, 'service.sqlite'));
    page = await openPage(home, '/episodes');
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('are listed by benchmark', async () => {
    const [benchmark, split] = [page.getByLabel('Benchmark'), page.getByLabel('Split', { exact: true })];
    await benchmark.selectOption({ label: 'REVERIE' });
    await page.getByRole('link', { name: '7_57_0' }).waitFor();
    expect(await page.locator('td b').count(), 'text is text').toBe(0);
    expect(await benchmark.locator('option').allTextContents()).toEqual(['R2R-Back', 'RxR', 'REVERIE', 'CVDN', 'SOON']);
    expect(await split.locator('option').allTextContents()).toEqual(['val_seen (1)', 'test (1, goals hidden)']);
    await inspect(page, 'episodes-reverie');
    await benchmark.selectOption({ label: 'RxR' });
    await page.locator('td[lang="hi-IN"]').waitFor();
    await page.getByRole('link', { name: '11_26' }).click();
    await ready(page);
  });

  it('of REVERIE are outlined where they are', async () => {
    await open('reverie');
    await page.getByText('Goal: to find the plant (object 57), seen from 2 viewpoints').waitFor();
    expect(await page.locator('.enfilade-map .seen').count()).toBe(2);
    expect(await page.locator('.enfilade-goal-lines path').count(), 'it is not seen from the start').toBe(0);
    await page.getByRole('button', { name: 'Look at it' }).click();
    const line = page.locator('.enfilade-goal-lines .line');
    await line.waitFor({ state: 'attached' });
    // The middle of the view looks at the middle of the box of view 12: 40 degrees at most from north.
    const [box, view] = [(await line.boundingBox())!, (await page.locator('.enfilade-canvas').boundingBox())!];
    expect(box.x + box.width / 2).toBeGreaterThan(view.x + view.width * 0.4);
    expect(box.x + box.width / 2).toBeLessThan(view.x + view.width * 0.6);
    expect(await page.locator('.enfilade-goal-lines text').textContent()).toBe('plant');
    await inspect(page, 'view-reverie');
    await page.evaluate(() => { const { viewer } = window.enfilade!; viewer.look(viewer.pose.heading + Math.PI, 0); });
    await line.waitFor({ state: 'detached' });
  });

  it('of CVDN are regions, asked for in a dialogue', async () => {
    await open('cvdn');
    const turns = page.locator('.said-turns li');
    expect(await turns.count()).toBe(2);
    expect(await turns.nth(0).textContent()).toBe('NavigatorLeft <i>or</i> right?');
    expect(await turns.nth(1).textContent()).toBe('Oracle after 2 stepsTo the left.');
    await page.getByText('Goal: the region of the chair, 2 viewpoints').waitFor();
    expect(await page.locator('.enfilade-map .seen').count()).toBe(2);
    await inspect(page, 'view-cvdn');
    await page.goto(`${home.server}/view?split=cvdn/val_seen&id=4`);
    await ready(page);
    expect(await page.locator('.instruction').textContent()).toBe('Looking for: chair');
  });

  it('of RxR come with their language and words in time', async () => {
    await open('rxr');
    await page.getByText('Language: Hindi (India)').waitFor();
    expect(await page.locator('.spoken').getAttribute('lang')).toBe('hi-IN');
    const player = page.getByRole('group', { name: 'The path with its words' });
    const time = player.getByLabel('Time in the fly-through');
    await time.fill('0.7');
    await page.locator('.spoken .said').getByText('सीधे').waitFor();
    await inspect(page, 'view-rxr');
    const before = await page.evaluate(() => window.enfilade!.viewer.pose.viewpoint);
    await player.getByRole('button', { name: 'Play' }).click();
    await player.getByRole('button', { name: 'Replay' }).waitFor();
    await page.locator('.spoken .said').getByText('रुको').waitFor();
    expect(await page.evaluate(() => window.enfilade!.viewer.pose.viewpoint)).not.toBe(before);
  });

  it('of SOON are outlined across heading 0, and described in parts', async () => {
    await open('soon');
    await page.getByText('Goal: to find the vase, shown at 1 viewpoint').waitFor();
    expect(await page.locator('.fields dd').allTextContents()).toContain('In the hall. ');
    await page.getByRole('button', { name: 'Look at it' }).click();
    const line = page.locator('.enfilade-goal-lines .line');
    await line.waitFor({ state: 'attached' });
    const [box, view] = [(await line.boundingBox())!, (await page.locator('.enfilade-canvas').boundingBox())!];
    expect(box.width).toBeLessThan(view.width / 2); // 30 degrees wide, not 330
    await inspect(page, 'view-soon');
  });

  it('of R2R-Back are turning points', async () => {
    await open('r2r-back');
    await page.getByRole('button', { name: 'Go there' }).click();
    await page.waitForFunction(() => {
      const { viewer } = window.enfilade!;
      return viewer.nextOnPath !== undefined && viewer.pose.viewpoint !== undefined;
    });
    expect(await page.locator('.enfilade-map .seen').count()).toBe(1);
  });

  it('that are hidden are not told', async () => {
    await open('reverie', 'test');
    await page.getByText('The goal of this one is hidden.').waitFor();
    expect(await page.locator('.enfilade-goal-lines path').count()).toBe(0);
    expect(await page.locator('.enfilade-map .seen').count()).toBe(0);
    const answer = await fetch(`${home.server}/api/v1/splits/test/episodes?task=reverie&id=8_0`);
    expect(Object.keys(((await answer.json()) as { episodes: object[] }).episodes[0]!)).not.toContain('goal');
  });

  it.each(['reverie', 'cvdn', 'rxr', 'r2r-back'])('of %s are judged alike by the server and by /try', async (task) => {
    const api = new Api(home.server);
    const send = (path: string, body: object, headers: Record<string, string> = {}) =>
      api.call<{ session: number; key: string }>(path,
        { method: 'POST', body: JSON.stringify(body), headers: { 'Content-Type': 'application/json', ...headers } });
    const [brief] = (await api.call<{ episodes: Episode[] }>(`splits/val_seen/episodes?task=${task}`)).episodes;
    const [episode] = (await api.call<{ episodes: Episode[] }>(`splits/val_seen/episodes?task=${task}&id=${brief!.instruction_id}`)).episodes;
    const { session, key } = await send('sessions', { task, split: 'val_seen', episode: episode!.instruction_id });
    const headers = { 'Enfilade-Session': key };
    await send(`sessions/${session}/calls`, { tool: 'stop' }, headers);
    const { error, length, ...rest } = await api.call<Outcome>(`sessions/${session}/outcome`, { headers });
    const scan = await api.scan(episode!.scan);
    const { error: own, length: walked, ...same } = judge(scan, episode!, [viewpointIndex(scan, episode!.start)])!;
    expect(rest).toMatchObject(same);
    expect(error).toBeCloseTo(own!, 3);
    expect(length).toBe(walked);
  });

  it('of REVERIE decide in /try, and its map has where the object is seen', async () => {
    await page.goto(`${home.server}/try?${new URLSearchParams({ split: 'reverie/val_seen', id: '7_57_0' })}`);
    await page.getByText('Water the <b>plant</b> in the corner.').waitFor();
    await page.getByRole('button', { name: 'Stop here' }).click();
    await page.getByText('Success is to stop at a viewpoint that shows the object.').waitFor();
    await page.getByRole('heading', { name: /^No success/ }).waitFor();
    expect(await page.locator('.enfilade-map .seen').count()).toBe(2);
  });

  it('broke no rule of the pages', () => {
    expect(complaints).toEqual([]);
  });
}, patience * 3);
