/** A server with phases of two benchmarks: each has its columns, and ranks by its own headline. */
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { complaints, type Home, inspect, missing, newData, pathsOf, results, scan, serve } from './harness.ts';
import { handIn, newTeam } from './teams.ts';

/** SYNTHETIC: each path of R2R with an object at its end, which is seen from there only. */
function writeReverie(data: string): void {
  const paths = pathsOf(data);
  mkdirSync(join(data, 'reverie'), { recursive: true });
  writeFileSync(join(data, 'reverie/REVERIE_val_seen.json'), JSON.stringify(paths.map((path, k) => ({
    id: `${k + 1}_${k + 10}`, path_id: k + 1, objId: k + 10, scan, heading: 0.5, path, instructions: ['Go to the plant at the end and water it.'],
  }))));
  const boxes: Record<string, Record<string, object>> = {};
  paths.forEach((path, k) => {
    for (const viewpoint of path) boxes[`${scan}_${viewpoint}`] ??= {};
    boxes[`${scan}_${path.at(-1)!}`]![k + 10] = { name: 'plant', visible_pos: [0], bbox2d: [[100, 100, 50, 80]] };
  });
  writeFileSync(join(data, 'reverie/BBoxes.json'), JSON.stringify(boxes));
}

/** Walks to the objects, and names them or others. */
const reverieResults = (data: string, right: boolean): string => JSON.stringify(pathsOf(data).map((path, k) => ({
  instr_id: `${k + 1}_${k + 10}_0`, trajectory: path.map((id) => [id, 0.5, 0]), predObjId: right ? k + 10 : 99,
})));

describe.skipIf(missing)('benchmarks', () => {
  let home: Home;
  beforeAll(async () => {
    const { folder, data } = newData();
    writeReverie(data);
    const phases = join(folder, 'phases.json');
    writeFileSync(phases, JSON.stringify({ phases: [
      { name: 'walks', title: 'Room-to-Room', split: 'val_seen' },
      { name: 'objects', title: 'REVERIE', split: 'val_seen', task: 'reverie' },
    ] }));
    home = await serve(folder, data, join(folder, 'service.sqlite'), ['--phases', phases]);
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('have their own checks, scores and columns', async () => {
    const page = await newTeam(home, 'Gardeners', '/submit?phase=objects');
    await page.getByText('REVERIE, scored as official.').waitFor();

    // A file of R2R's form: nothing was named.
    await handIn(page, 'walks', reverieResults(home.folder, true).replaceAll(/,"predObjId":\d+/g, ''));
    await page.getByRole('alert').waitFor();
    expect(await page.getByRole('alert').textContent()).toContain('neither predObjId nor pred_objid');

    await handIn(page, 'looks elsewhere', reverieResults(home.folder, false));
    await page.getByRole('row', { name: /looks elsewhere.*scored/ }).waitFor();
    await handIn(page, 'finds it', reverieResults(home.folder, true));
    await page.getByRole('row', { name: /finds it.*scored/ }).waitFor();
    await page.getByLabel('Phase').selectOption('walks');
    await handIn(page, 'walks', await results(home, true));
    await page.getByRole('row', { name: /walks.*scored/ }).waitFor();
    // A table for each benchmark.
    const heads = async (label: string) => page.getByRole('region', { name: label }).getByRole('columnheader').allTextContents();
    expect((await heads('Submissions to REVERIE, scored as official')).slice(3, 6)).toEqual(['RGSPL%', 'RGS%', 'SR%']);
    expect((await heads('Submissions to R2R')).slice(3, 6)).toEqual(['SPL%', 'SR%', 'OSR%']);
    await inspect(page, 'submit-benchmarks');

    await page.goto(`${home.server}/leaderboard?phase=objects`);
    await page.getByRole('cell', { name: /Gardeners/ }).waitFor();
    expect((await page.getByRole('table').getByRole('columnheader').allTextContents()).slice(2, 8))
      .toEqual(['RGSPL%', 'RGS%', 'SR%', 'OSR%', 'SPL%', 'TLm']);
    const row = page.locator('tbody tr');
    expect(await row.count()).toBe(1); // both walked as well: what was named decides
    expect(await row.textContent()).toContain('finds it');
    expect(await row.locator('td.number').nth(1).textContent()).toMatch(/^100\.0/); // RGS; one of the ways there is no shortest one
    await page.locator('dl.facts').getByText('RGSPL').waitFor();
    await page.getByRole('heading', { name: 'Progress' }).waitFor();
    await inspect(page, 'leaderboard-reverie');

    await page.getByRole('link', { name: 'Room-to-Room' }).click();
    await page.getByRole('columnheader', { name: 'nDTW' }).waitFor();
    expect(await page.getByRole('columnheader', { name: 'RGSPL' }).count()).toBe(0);
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
