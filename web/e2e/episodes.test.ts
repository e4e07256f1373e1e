/** The list of episodes by benchmark and split, and the page of an episode: neighbours, instructions, pieces, links. */
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest';
import { type Episode, shownText } from '../src/episodes/episode.ts';
import { episodesOf, floorKey, type Split, splitKey, type SplitList } from '../src/episodes/splits.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import { complaints, enfilade, type Home, inspect, missing, newFolder, openPage, patience, serve } from './harness.ts';

declare const window: { enfilade?: { viewer: Viewer } };

interface EpisodeList { readonly matching: number; readonly title: string; readonly goals_hidden: boolean; readonly episodes: readonly Episode[] }

/** Homes with all benchmarks. @param size of their pictures, texels; 0: none */
function makeSet(data: string, seed: string, count: string, size: string): void {
  enfilade('homes', '-o', data, '--homes', count, '--seed', seed, '--kind', 'flat', '--area', '60', '--size', size, '--samples', '1',
    '--light', 'coarse', '--paths', '6', '--tasks', 'all');
}

const asker = (home: () => Home) => async <T>(path: string): Promise<T> => {
  const answer = await fetch(`${home().server}/api/v1/${path}`);
  expect(answer.status, path).toBe(200);
  return answer.json() as Promise<T>;
};

/** What every episode of a split must be like. */
function expectReadable(key: string, { task }: Split, { instruction, instruction_id: id, goal }: Episode): void {
  const shown = shownText(instruction, task);
  expect(shown, `${key} ${id}`).not.toMatch(/<(NAV|ORA|TAR)>/);
  if (task === 'r4r') expect(shown, `${key} ${id}`).not.toMatch(/[a-z][.!?]?[A-Z][a-z]/);
  // A goal's name stands after "to find the".
  if (goal?.name) expect(goal.name, `${key} ${id}`).not.toMatch(/^(find|look|I want|this is|the) /i);
}

describe.skipIf(missing)('episodes of three sets of homes', () => {
  let home: Home | undefined;
  const ask = asker(() => home!);
  afterEach(async () => {
    await home?.stop();
    home = undefined;
  });

  it.each([['1', '3'], ['2', '3'], ['3', '5']])('can be read, in order, and keep what is secret (seed %s, %s homes)', async (seed, count) => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    makeSet(data, seed, count, '0');
    home = await serve(folder, data, join(folder, 'service.sqlite'));
    const { splits } = await ask<SplitList>('splits?task=all');
    expect(new Set(splits.map(({ task }) => task)).size).toBe(8);
    let pieces = 0;
    for (const split of splits.filter(({ instructions }) => instructions > 0)) {
      const key = splitKey(split);
      const { episodes, matching } = await ask<EpisodeList>(episodesOf(key, { limit: '500' }));
      const ids = episodes.map(({ instruction_id }) => instruction_id);
      const step = Math.ceil(ids.length / 7); // some of each
      for (let k = 0; k < ids.length; k += step) {
        const { episodes: [episode] } = await ask<EpisodeList>(episodesOf(key, { id: ids[k]! }));
        expect([episode!.number, episode!.of, episode!.previous, episode!.next], key).toEqual([k + 1, matching, ids[k - 1], ids[k + 1]]);
        expectReadable(key, split, episode!);
        const own = episode!.instructions!.map(({ instruction_id }) => instruction_id);
        expect(own).toContain(ids[k]);
        const paths = own.map((id) => episodes.find(({ instruction_id }) => instruction_id === id)?.path);
        if (matching <= 500) expect(new Set(paths.map((path) => JSON.stringify(path))).size, `${key} ${ids[k]}`).toBe(1);
        if (split.goals_hidden) {
          for (const secret of ['path', 'goal', 'distance', 'trace']) expect(episode, `${key} ${ids[k]}`).not.toHaveProperty(secret);
          expect(JSON.stringify(episode)).not.toContain('"places"');
        } else if (split.task === 'r2r') {
          const places = episode!.parts!.map((part) => part.places!);
          expect([places[0]![0], places.at(-1)![1]]).toEqual([0, episode!.path!.length - 1]);
          ++pieces;
        }
      }
    }
    expect(pieces).toBeGreaterThan(5);
  }, patience * 3);
});

const ready = (page: Page) => page.waitForFunction(() => window.enfilade !== undefined);

describe.skipIf(missing)('an episode', () => {
  let home: Home;
  let page: Page;
  const ask = asker(() => home);
  type Query = Readonly<Record<string, string>>;
  const of = async (key: string) => (await ask<EpisodeList>(episodesOf(key, { limit: '500' }))).episodes;
  const address = (key: string, id: string, more: Query = {}) => `/view?${new URLSearchParams({ split: key, id, ...more })}`;
  const open = async (key: string, id: string, more: Query = {}) => {
    await page.goto(home.server + address(key, id, more));
    await ready(page);
  };
  const hrefOf = (name: string) => page.getByRole('link', { name, exact: true }).getAttribute('href');

  beforeAll(async () => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    makeSet(data, '1', '3', '64');
    enfilade('continuous', data);
    enfilade('continuous', data, '--task', 'rxr-ce');
    enfilade('ask', '--data', data, '--split', 'val_unseen', '--stand-in', 'oracle', '-o', join(folder, 'runs/oracle'));
    home = await serve(folder, data, join(folder, 'service.sqlite'), ['--runs', join(folder, 'runs')]);
    page = await openPage(home, '/episodes');
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('is listed by benchmark and split', async () => {
    const [benchmark, split] = [page.getByLabel('Benchmark'), page.getByLabel('Split', { exact: true })];
    await page.getByRole('link', { name: (await of('val_unseen'))[0]!.instruction_id, exact: true }).waitFor(); // what is looked at most
    const textsOf = (select: typeof split) => select.locator('option').allTextContents();
    expect(await textsOf(benchmark)).toEqual(
      ['R2R', 'R2R-Last', 'R2R-Back', 'R4R', 'RxR', 'REVERIE', 'CVDN', 'SOON', 'R2R-CE', 'RxR-CE']);
    expect((await textsOf(split)).map((text) => text.replace(/ \(.*/, ''))).toEqual(['val_unseen', 'val_seen', 'test', 'train']);
    await benchmark.selectOption({ label: 'RxR' }); // the same split of it
    await page.locator('td[lang^="en-"]').first().waitFor();
    expect(new URL(page.url()).searchParams.get('split')).toBe('rxr/val_unseen');
    await split.selectOption({ value: 'rxr/train' });
    await page.getByRole('link', { name: (await of('rxr/train'))[0]!.instruction_id, exact: true }).waitFor();
    await page.goto(`${home.server}/episodes?split=reverie/val_seen`); // as it was always written
    await page.getByRole('link', { name: (await of('reverie/val_seen'))[0]!.instruction_id, exact: true }).waitFor();
    expect([await benchmark.inputValue(), await split.inputValue()]).toEqual(['reverie', 'reverie/val_seen']);
    await inspect(page, 'episodes-benchmarks');
    await page.goto(`${home.server}/episodes?split=nosuch`);
    await page.getByText('This data set has no split "nosuch" with episodes. Shown is val_unseen.').waitFor();
  });

  it('of continuous space leads to the floor', async () => {
    for (const [benchmark, to] of [['R2R-CE', 'val_unseen'], ['RxR-CE', 'rxr-ce/val_unseen']] as const) {
      const key = floorKey(to);
      await page.goto(`${home.server}/episodes`);
      await page.getByLabel('Benchmark').selectOption({ label: benchmark });
      const [first] = (await ask<{ episodes: { id: string; instruction: string }[] }>(episodesOf(key, { limit: '1' }))).episodes;
      const link = page.getByRole('link', { name: first!.id, exact: true });
      await link.waitFor();
      expect(await link.getAttribute('href')).toBe(`/roam?${new URLSearchParams({ split: to, id: first!.id })}`);
      expect(await page.getByLabel('Results file').isVisible(), 'of trajectories on a graph').toBe(false);
      await page.goto(home.server + (await link.getAttribute('href'))!);
      await page.locator('.instruction').waitFor();
      expect(await page.locator('.instruction').textContent()).toBe(first!.instruction);
    }
  });

  it('says which it is, and leads to its neighbours, its list, and what can be done with it', async () => {
    const all = await of('val_unseen');
    const [before, one, after] = all.slice(3, 6).map(({ instruction_id }) => instruction_id) as [string, string, string];
    await open('val_unseen', one);
    await page.getByRole('heading', { name: `Episode ${one}`, level: 1 }).waitFor();
    expect(await page.title()).toBe(`${one}, R2R val_unseen · Enfilade`);
    await page.getByText(`5 of ${all.length}`).waitFor();
    expect([await hrefOf('Previous'), await hrefOf('Next')]).toEqual([address('val_unseen', before), address('val_unseen', after)]);
    expect(await hrefOf('Episodes of R2R val_unseen')).toBe('/episodes?split=val_unseen');
    expect(await hrefOf('Follow it yourself')).toBe(`/try?${new URLSearchParams({ split: 'val_unseen', id: one })}`);
    expect(await hrefOf('Play it as a language model')).toBe(`/play?${new URLSearchParams({ task: 'r2r', split: 'val_unseen', episode: one })}`);
    await page.getByRole('heading', { name: 'Replay of runs' }).waitFor();
    expect(await hrefOf('oracle')).toBe(`/replay?${new URLSearchParams({ run: 'oracle', episode: one })}`);
    const path = one.split('_')[0];
    const others = await page.locator('.other-instructions li a').allTextContents();
    expect(others).toEqual(all.map(({ instruction_id }) => instruction_id).filter((id) => id.startsWith(`${path}_`) && id !== one));
    expect(others.length).toBe(2);
    await page.getByRole('link', { name: 'Next', exact: true }).click();
    await page.getByRole('heading', { name: `Episode ${after}`, level: 1 }).waitFor();
    await open('val_unseen', all[0]!.instruction_id);
    expect(await page.getByRole('link', { name: 'Previous', exact: true }).count()).toBe(0);
  });

  it('has its neighbours in the list in which it was chosen', async () => {
    const all = await of('val_unseen');
    const word = all[0]!.instruction.split(' ').find((one) => one.length > 4)!.toLowerCase();
    const found = all.filter(({ instruction }) => instruction.toLowerCase().includes(word)).map(({ instruction_id }) => instruction_id);
    await page.goto(`${home.server}/episodes?${new URLSearchParams({ split: 'val_unseen', q: word })}`);
    await page.getByRole('link', { name: found[0]!, exact: true }).click();
    await ready(page);
    await page.getByText(`1 of ${found.length}`).waitFor();
    if (found.length > 1) expect(await hrefOf('Next')).toBe(address('val_unseen', found[1]!, { q: word }));
    await page.getByRole('link', { name: 'Episodes of R2R val_unseen', exact: true }).click();
    await page.getByText(`1 to ${Math.min(found.length, 50)} of ${found.length}`).waitFor();
    expect(await page.getByLabel('Words in the instruction').inputValue()).toBe(word);
    // In an order that only the browser knows.
    await page.getByLabel('Words in the instruction').fill('');
    await page.getByLabel('Sort by').selectOption('longest');
    const links = page.locator('tbody td:first-child a');
    const longest = [...all].sort((a, b) => b.distance! - a.distance!);
    // Its address and not its text: the first of the order before may be the longest.
    await expect.poll(() => links.first().getAttribute('href'), { timeout: patience })
      .toBe(address('val_unseen', longest[0]!.instruction_id, { sort: 'longest' }));
    const ids = await links.allTextContents();
    await links.nth(1).click();
    await ready(page);
    await page.getByText(`2 of ${all.length}`).waitFor();
    expect([await hrefOf('Previous'), await hrefOf('Next')]).toEqual([ids[0]!, ids[2]!].map((id) => address('val_unseen', id, { sort: 'longest' })));
  });

  it('has pieces that mark their viewpoints, and are marked while one flies along', async () => {
    const { episodes: [one] } = await ask<EpisodeList>(episodesOf('val_unseen', { id: (await of('val_unseen'))[0]!.instruction_id }));
    await open('val_unseen', one!.instruction_id);
    const parts = page.locator('.parts li');
    expect(await parts.count()).toBe(one!.parts!.length);
    const last = one!.parts!.at(-1)!;
    const [from, to] = last.places!;
    await page.getByText(from === to ? `viewpoint ${from + 1}` : `viewpoints ${from + 1} to ${to + 1}`, { exact: true }).last().waitFor();
    const marked = page.locator('.enfilade-map .marked');
    expect(await marked.count()).toBe(0);
    await parts.last().getByRole('button').hover();
    await expect.poll(() => marked.count(), { timeout: patience }).toBe(to - from + 1);
    await page.mouse.move(5, 5);
    await expect.poll(() => marked.count(), { timeout: patience }).toBe(0);
    await parts.first().getByRole('button').focus();
    await expect.poll(() => marked.count(), { timeout: patience }).toBeGreaterThan(0);
    await inspect(page, 'view-pieces');
    await parts.first().getByRole('button').blur();
    const time = page.getByRole('group', { name: 'Fly-through of the path' }).getByLabel('Time in the fly-through');
    await time.press('End');
    await expect.poll(() => parts.last().getAttribute('class'), { timeout: patience }).toContain('said');
    expect(await marked.count()).toBeGreaterThan(0);
  });

  it('shows the trajectory of a submission whose team allows it', async () => {
    const episodes = await of('val_unseen');
    const send = async <T>(path: string, init: RequestInit): Promise<T> => {
      const answer = await fetch(`${home.server}/api/v1/${path}`, init);
      expect(answer.ok, await answer.clone().text()).toBe(true);
      return answer.json() as Promise<T>;
    };
    const json = { 'Content-Type': 'application/json' };
    const { token } = await send<{ token: string }>('teams', { method: 'POST', headers: json, body: JSON.stringify({ name: 'Walkers' }) });
    const headers = { ...json, Authorization: `Bearer ${token}` };
    const results = JSON.stringify(episodes.map(({ instruction_id, start }) => ({ instr_id: instruction_id, trajectory: [[start, 0, 0]] })));
    const { id } = await send<{ id: number }>('submissions?phase=val_unseen&method=stays', { method: 'POST', headers, body: results });
    await expect.poll(async () => (await send<{ state: string }>(`submissions/${id}`, { headers })).state, { timeout: patience }).toBe('scored');
    const [one, two] = episodes.map(({ instruction_id }) => instruction_id) as [string, string];
    await open('val_unseen', one, { submission: String(id) });
    await page.getByRole('alert').getByText('team does not show its trajectories').waitFor();
    await send(`submissions/${id}/method`, { method: 'PUT', headers, body: JSON.stringify({ walks_public: true }) });
    await open('val_unseen', one);
    await page.getByRole('heading', { name: 'Trajectories of submissions' }).waitFor();
    await page.getByRole('link', { name: 'stays', exact: true }).click();
    await page.getByText('The agent walked 0.0 m and stopped').waitFor();
    expect(await page.locator('.enfilade-map .walk').count()).toBe(1);
    expect(await hrefOf(`Submission ${id}`)).toBe(`/submission?${new URLSearchParams({ id: String(id) })}`);
    expect(await hrefOf('Next')).toBe(address('val_unseen', two, { submission: String(id) }));
    await inspect(page, 'view-submission');
  });

  it('of other benchmarks has its text in words', async () => {
    const [dialogue] = await of('cvdn/val_unseen');
    await page.goto(`${home.server}/episodes?split=cvdn/val_unseen`);
    const row = page.locator('tbody tr').first();
    await row.waitFor();
    expect(await row.textContent()).toContain('Looking for: ');
    expect(await page.locator('tbody').textContent()).not.toContain('<TAR>');
    await open('cvdn/val_unseen', dialogue!.instruction_id);
    expect(await page.locator('.panel').textContent()).not.toContain('<TAR>');
    const [joined] = await of('r4r/val_unseen');
    if (joined) {
      await open('r4r/val_unseen', joined.instruction_id);
      expect((await page.locator('.instruction').innerText()).split('\n').length).toBeGreaterThan(1);
    }
    const key = (await ask<SplitList>('splits?task=soon')).splits.find(({ goals_hidden, instructions }) => !goals_hidden && instructions > 0);
    const [described] = await of(splitKey(key!));
    await open(splitKey(key!), described!.instruction_id);
    expect(await page.locator('.goal-part p').textContent()).toMatch(/^Goal: to find the [a-z ]+, shown at \d+ viewpoints?$/);
    const [spoken] = await of('rxr/val_unseen');
    await open('rxr/val_unseen', spoken!.instruction_id);
    await page.locator('.other-instructions .badge').getByText('English').first().waitFor();
    await inspect(page, 'view-languages');
  });

  it('of a secret split tells nothing more', async () => {
    const [one] = await of('test');
    await open('test', one!.instruction_id);
    await page.getByText('The goal of this one is hidden.').waitFor();
    expect(await page.locator('.parts, .enfilade-player').count()).toBe(0);
    expect(await page.getByRole('link', { name: 'Follow it yourself' }).count()).toBe(0);
    await page.getByRole('link', { name: 'Play it as a language model' }).waitFor();
  });

  it('that is not there is named, with a way back', async () => {
    await page.goto(`${home.server}/view?split=val_unseen&id=nosuch`);
    await page.getByText('Split val_unseen has no episode "nosuch".').waitFor();
    await inspect(page, 'view-none');
    await page.getByRole('link', { name: 'Episodes of val_unseen' }).click();
    await page.getByRole('link', { name: (await of('val_unseen'))[0]!.instruction_id, exact: true }).waitFor();
    await page.getByRole('link', { name: 'Runs', exact: true }).waitFor();
    const links = (at: Page) => at.locator('header nav a').evaluateAll((all) =>
      all.filter((link) => !(link as HTMLElement).hidden).map((link) => `${link.getAttribute('href')} ${link.textContent}`));
    const pages = await links(page);
    const badge = await page.locator('header .synthetic').textContent();
    await page.goto(`${home.server}/nothing`);
    expect(await links(page)).toEqual(pages);
    expect(await page.locator('header .synthetic').textContent()).toBe(badge);
    const [one] = await of('val_unseen');
    const other = (await ask<{ scans: { scan: string }[] }>('scans')).scans.find(({ scan }) => scan !== one!.scan)!.scan;
    await page.goto(`${home.server}${address('val_unseen', one!.instruction_id)}#${other}`);
    await page.getByRole('alert').getByText(`is in ${one!.scan}, and the address names ${other}.`).waitFor();
    await page.getByRole('link', { name: `Open it in ${one!.scan}` }).click();
    await page.getByRole('heading', { name: 'Reference path' }).waitFor();
    await page.goto(`${home.server}/view?split=nosuch&id=1_0`);
    await page.getByRole('alert').getByText('there is no "nosuch"; allowed are').waitFor();
  });

  it('broke no rule of the pages', () => {
    expect(complaints).toEqual([]);
  });
}, patience * 3);
