/** Submitting, the leaderboard's rows, and the page of a submission's method. */
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { complaints, type Home, inspect, makeHomes, missing, newFolder, newToken, openPage, scan, serve } from './harness.ts';
import { handIn, newTeam } from './teams.ts';

interface Entry { readonly image_id: string; readonly unobstructed: readonly boolean[]; readonly pose: readonly number[] }

/** Six paths of the home, each from a viewpoint to one that is so far away that whoever stays has no success. */
function longPaths(data: string): string[][] {
  const graph = JSON.parse(readFileSync(join(data, `connectivity/${scan}_connectivity.json`), 'utf8')) as Entry[];
  const away = (a: number, b: number) => Math.hypot(...[3, 7, 11].map((k) => graph[a]!.pose[k]! - graph[b]!.pose[k]!));
  const pathsFrom = (start: number): number[][] => {
    const paths = [[start]];
    const known = new Set([start]);
    for (const path of paths) {
      graph[path.at(-1)!]!.unobstructed.forEach((open, to) => {
        if (!open || known.has(to)) return;
        known.add(to);
        paths.push([...path, to]);
      });
    }
    return paths;
  };
  const found = graph.flatMap((_, start) => pathsFrom(start).filter((path) => away(start, path.at(-1)!) > 3.5).slice(0, 1));
  return found.slice(0, 6).map((path) => path.map((v) => graph[v]!.image_id));
}

/** SYNTHETIC: the first paths as val_seen, the others as val_unseen. */
function writeSplits(data: string): void {
  mkdirSync(join(data, 'r2r'), { recursive: true });
  const all = longPaths(data).map((path, k) => ({
    path_id: k + 1, scan, heading: 0.5, path, distance: 4, instructions: ['Walk on.', '<img src=x onerror=alert(1)> Turn left.', 'Go to the end.'],
  }));
  writeFileSync(join(data, 'r2r/R2R_val_seen.json'), JSON.stringify(all.slice(0, 3)));
  writeFileSync(join(data, 'r2r/R2R_val_unseen.json'), JSON.stringify(all.slice(3)));
}

/** A results file of a split. @param walks of the paths in their order: to the goal, or nowhere */
function resultsOf(data: string, split: 'val_seen' | 'val_unseen', walks: readonly boolean[]): string {
  const first = split === 'val_seen' ? 0 : 3;
  return JSON.stringify(longPaths(data).slice(first, first + 3).flatMap((path, k) => [0, 1, 2].map((instruction) => ({
    instr_id: `${first + k + 1}_${instruction}`, trajectory: (walks[k] ? path : path.slice(0, 1)).map((id) => [id, 0.5, 0]),
  }))));
}

describe.skipIf(missing)('the leaderboard', () => {
  let home: Home;
  beforeAll(async () => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    makeHomes(data);
    writeSplits(data);
    home = await serve(folder, data, join(folder, 'service.sqlite'));
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('opens with val unseen, and says how one submits where nobody has', async () => {
    const page = await openPage(home, '/leaderboard');
    await page.getByRole('heading', { name: 'No results yet' }).waitFor();
    const tabs = page.getByRole('navigation', { name: 'Phases' }).getByRole('link');
    expect(await tabs.allTextContents()).toEqual(['val_unseen', 'val_seen']);
    expect(await tabs.first().getAttribute('aria-current')).toBe('page');
    const commands = await page.locator('.empty pre').textContent();
    expect(commands).toContain('enfilade run --data DATA --split val_unseen');
    expect(commands).toContain(`enfilade submit results.json --server ${home.server} --phase val_unseen`);
    await inspect(page, 'leaderboard-empty');
    await page.close();
  });

  it('is led to from a submission, also from one that was sent to the wrong split', async () => {
    const page = await newTeam(home, 'Ada');
    expect(await page.getByLabel('Phase').inputValue()).toBe('val_unseen');
    await handIn(page, 'walks', resultsOf(home.folder, 'val_seen', [true, true, false]));
    await page.getByText('This is a file of val_seen, not of val_unseen.').waitFor();
    expect(await page.getByRole('alert').count()).toBe(1); // and no line for each entry
    await inspect(page, 'submit-other-split');
    // What goes wrong there is said as well.
    await page.route('**/api/v1/submissions?phase=val_seen&*', (route) =>
      route.fulfill({ status: 429, json: { error: { code: 'too-many', message: 'Too many files for today' } } }), { times: 1 });
    await page.getByRole('button', { name: 'Submit it to val_seen' }).click();
    await page.getByText('Too many files for today').waitFor();
    await page.getByLabel('Phase').selectOption('val_unseen');
    await page.getByRole('button', { name: 'Check and submit' }).click();
    await page.getByRole('button', { name: 'Submit it to val_seen' }).click();
    await page.getByText('The file is valid: submission 1.').waitFor();
    expect(await page.getByLabel('Phase').inputValue()).toBe('val_seen');
    await page.getByRole('link', { name: 'Rank 1 of 1: see the row' }).click();
    await page.waitForURL(/leaderboard\?phase=val_seen#submission-1$/);
    const row = page.locator('#submission-1');
    await row.waitFor();
    expect(await row.getAttribute('class')).toContain('target');
    expect(await row.textContent()).toContain('yours');
    expect(await page.getByRole('heading', { name: 'Progress' }).count()).toBe(0); // nothing to draw of one submission
    expect(await page.getByRole('heading', { name: 'Compare two submissions' }).count()).toBe(0);

    // Of one team's two the worse has no row: the link is to the better.
    await page.goto(`${home.server}/submit?phase=val_seen`);
    await handIn(page, 'stays', resultsOf(home.folder, 'val_seen', [false, false, false]));
    await page.getByText("Your team's best stays submission 1.").waitFor();
    await page.goto(`${home.server}/leaderboard?phase=val_seen#submission-2`);
    await page.getByText('Submission 2 has no row here').waitFor();
    await page.getByRole('heading', { name: 'Progress' }).waitFor();
    await page.close();
  });

  it('compares two submissions', async () => {
    const ada = await newTeam(home, 'Grace');
    await ada.getByLabel('Phase').selectOption('val_unseen');
    await handIn(ada, 'goes twice', resultsOf(home.folder, 'val_unseen', [true, true, false]));
    await ada.getByText('Rank 1 of 1').waitFor();
    await handIn(ada, 'goes once', resultsOf(home.folder, 'val_unseen', [false, true, false]));
    await ada.getByText("Your team's best stays submission 3.").waitFor();
    await ada.goto(`${home.server}/leaderboard`);
    await ada.getByLabel('Compare').selectOption({ label: 'Grace: goes once (4)' });
    await ada.getByLabel('with', { exact: true }).selectOption({ label: 'Grace: goes twice (3)' });
    await ada.getByRole('button', { name: 'Compare' }).click();
    const row = ada.getByRole('region', { name: 'Comparison' }).getByRole('row', { name: /^SR/ });
    await row.waitFor();
    expect(await ada.getByText('Paired bootstrap over 3 paths, 1,000 draws').count()).toBe(1);
    const cells = await row.getByRole('cell').allTextContents();
    expect(Number(cells[2]) - Number(cells[1])).toBeCloseTo(Number(cells[3]!.replace('−', '-')), 0);
    expect(cells[4]).toContain(' to ');
    expect(Number(cells[5])).toBeGreaterThan(0.05); // one path of three says little
    await inspect(ada, 'leaderboard-compared');
    await ada.close();
  });

  // Model homes have none, as nobody else has measured them: the server's answer gets one here.
  it('has what others have published in grey, without a rank', async () => {
    const page = await openPage(home, '/');
    await page.route('**/api/v1/leaderboards/*', async (route) => {
      const response = await route.fetch();
      const board = (await response.json()) as object;
      const human = { agent: 'Human', source: 'Anderson et al., CVPR 2018, table 1', means: { success: { mean: 0.864 } } };
      await route.fulfill({ response, json: { ...board, published: [human] } });
    });
    await page.goto(`${home.server}/leaderboard?phase=val_seen&sort=success`);
    const row = page.locator('tr.published');
    await row.waitFor();
    const cells = await row.getByRole('cell').allTextContents();
    expect(cells[0]).toBe('–');
    expect(cells[1]).toContain('Anderson et al., CVPR 2018, table 1');
    expect(cells).toContain('86.4');
    const first = page.locator('tbody tr').first();
    expect(await first.textContent()).toContain('Human'); // among the others, as the table is sorted
    expect(await page.locator('tbody tr:not(.published) td.rank').first().textContent()).toBe('1');
    await page.getByText('Grey rows are figures that others have published').waitFor();
    await inspect(page, 'leaderboard-published');
    await page.close();
  });

  it('leads to a page of the method, which its team describes', async () => {
    const page = await newTeam(home, 'Mary');
    await handIn(page, 'maps', resultsOf(home.folder, 'val_unseen', [true, false, false]));
    await page.getByRole('link', { name: 'Describe the method' }).click();
    await page.getByRole('heading', { level: 1, name: 'maps yours' }).waitFor();
    await page.getByText('Nothing is said of this method yet.').waitFor();
    const row = page.getByRole('region', { name: 'Results by building' }).getByRole('row', { name: new RegExp(scan) });
    await row.waitFor();
    expect(await row.getByRole('cell').nth(1).textContent()).toBe('9');
    expect(await page.getByRole('region', { name: 'Results by path length' }).getByRole('row').count()).toBeGreaterThan(1);

    await page.getByText('Describe this method').click();
    await page.getByLabel('Description').fill('A **map** of all.\n\n<img src=x onerror=alert(1)>');
    await page.getByLabel('BibTeX').fill('@article{maps, title={Maps}}');
    await page.getByLabel('Paper').fill('https://example.org/maps');
    await page.getByLabel('Weights').selectOption('open');
    await page.getByRole('button', { name: 'Save' }).click();
    await page.locator('.prose strong').getByText('map').waitFor();
    expect(await page.locator('.prose img').count()).toBe(0); // what people write is never markup
    expect(await page.locator('.prose').textContent()).toContain('<img src=x');
    expect(await page.getByRole('link', { name: 'Paper of maps' }).getAttribute('href')).toBe('https://example.org/maps');
    await page.getByText('Only your team and the organisers see these').waitFor();
    await inspect(page, 'submission');
    const address = page.url();

    // Others see no trajectory before the team shows them.
    const visitor = await openPage(home, address.slice(home.server.length));
    await visitor.getByRole('region', { name: 'Results by building' }).waitFor();
    expect(await visitor.getByRole('heading', { name: 'Worst episodes' }).count()).toBe(0);
    expect(await visitor.getByText('Describe this method').count()).toBe(0);

    await page.getByText('Describe this method').click();
    await page.getByLabel('Everybody may see the trajectories').check();
    await Promise.all([page.waitForEvent('load'), page.getByRole('button', { name: 'Save' }).click()]);
    await visitor.reload();
    await visitor.getByRole('heading', { name: 'Worst episodes' }).waitFor();
    const card = visitor.locator('.worst > li').first();
    await card.getByRole('img', { name: /^Where it stopped/ }).scrollIntoViewIfNeeded();
    await expect.poll(() => card.locator('img').evaluateAll((all) => all.every((one) => (one as HTMLImageElement).naturalWidth > 0))).toBe(true);
    expect(await card.locator('img').count()).toBe(2);
    await card.getByText('Map', { exact: true }).click();
    await card.locator('.enfilade-map .path').waitFor();
    expect(await card.locator('.enfilade-map .stop').count()).toBe(1);
    await inspect(visitor, 'submission-visitor');
    const id = await card.getByRole('link').first().textContent();
    await card.getByRole('link').first().click();
    await visitor.waitForURL(new RegExp(`/view\\?.*id=${id}&submission=5`));
    await visitor.getByRole('link', { name: 'Submission 5', exact: true }).waitFor();
    await visitor.close();
    await page.close();
  });

  it('shows nobody what is not on it', async () => {
    const page = await openPage(home, '/submission?id=99');
    await page.getByText('No such submission').waitFor();
    await page.getByRole('link', { name: 'Go to Leaderboard' }).waitFor();
    await page.goto(`${home.server}/submission`);
    await page.getByText('The address names no submission').waitFor();
    await inspect(page, 'submission-none');
    await page.close();
  });

  it('lets organisers describe a method too', async () => {
    const page = await openPage(home, '/submission?id=1');
    await page.getByRole('heading', { name: 'By building' }).waitFor();
    expect(await page.getByText('Describe this method').count()).toBe(0);
    await page.evaluate((token) => fetch('/api/v1/session', {
      method: 'POST', body: JSON.stringify({ token }), headers: { 'X-Enfilade': '1', 'Content-Type': 'application/json' },
    }).then(({ ok }) => ok), newToken(home, 'Otto', 'organiser'));
    await page.goto(`${home.server}/submission?id=1`);
    await page.getByText('Describe this method').waitFor();
    expect(await page.getByText('yours', { exact: true }).count()).toBe(0);
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
