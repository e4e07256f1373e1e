import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { complaints, type Home, inspect, makeHomes, missing, openHome, openPage, results } from './harness.ts';

describe.skipIf(missing)('the pages', () => {
  let home: Home;
  beforeAll(async () => {
    home = await openHome();
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('take a team from its making to the leaderboard', async () => {
    const page = await openPage(home, '/submit');
    await page.getByLabel("The team's name").fill('<b>Team</b> "A"');
    await page.getByRole('button', { name: 'Make the team' }).click();
    await page.locator('.token').waitFor();
    await inspect(page, 'submit-team');
    await page.getByRole('button', { name: 'Log in' }).click();
    await page.getByText('You are').waitFor();

    const file = (content: string) => ({ name: 'r.json', mimeType: 'application/json', buffer: Buffer.from(content) });
    await page.getByLabel('Method').fill('walks');
    await page.getByLabel('Results file').setInputFiles(file('[{"instr_id": "1_0"}]'));
    await page.getByRole('button', { name: 'Check and hand in' }).click();
    await page.getByRole('alert').waitFor();
    expect(await page.getByRole('alert').textContent()).toContain('$[0]');
    await inspect(page, 'submit-faults');

    await page.getByLabel('Results file').setInputFiles(file(await results(home, true)));
    await page.getByRole('button', { name: 'Check and hand in' }).click();
    await page.getByText('The file is good').waitFor();
    await page.getByRole('cell', { name: 'scored' }).waitFor();
    await page.getByLabel('Method').fill('stays');
    await page.getByLabel('Results file').setInputFiles(file(await results(home, false)));
    await page.getByRole('button', { name: 'Check and hand in' }).click();
    await page.getByText('submission 2').first().waitFor();
    await inspect(page, 'submit-scored');

    await page.goto(`${home.server}/leaderboard`);
    await page.getByRole('cell', { name: '<b>Team</b> "A"' }).waitFor();
    expect(await page.locator('tbody tr').count()).toBe(1); // the better of the two
    expect(await page.locator('tbody').textContent()).toContain('100.0');
    await page.getByRole('button', { name: 'NE' }).click();
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
    await page.close();
  });

  it("show an agent's walk beside the reference", async () => {
    const page = await openPage(home, '/episodes');
    const content = Buffer.from(await results(home, false));
    await page.getByLabel('Results file').setInputFiles({ name: 'r.json', mimeType: 'application/json', buffer: content });
    await page.getByText('18 walks').waitFor();
    await page.getByRole('link', { name: '1_0' }).click();
    await page.getByText('no success').waitFor();
    expect(await page.locator('.enfilade-map .walk').count()).toBe(1);
    await inspect(page, 'view-walk');
    await page.close();
  });

  it('correct a graph, in the file that the program applies', async () => {
    const page = await openPage(home, '/verify#home_0001');
    await page.getByLabel('Who you are').fill('Ada');
    await page.getByRole('button', { name: /^Remove the edge/ }).first().click();
    await page.getByText('Say who you are, and why.').waitFor();
    await page.getByLabel('Why').fill('a rope');
    const removed = page.getByRole('button', { name: /^Remove the edge/ });
    const before = await removed.count();
    await removed.first().click();
    await page.getByText('remove-edge').waitFor();
    expect(await removed.count()).toBe(before - 1);
    await page.reload(); // nothing is lost
    await page.getByText('remove-edge').waitFor();
    await page.getByRole('button', { name: 'Undo correction 1' }).click();
    await page.getByText('None yet.').waitFor();
    await page.getByLabel('Why').fill('a rope');
    await removed.first().click();
    await inspect(page, 'verify-corrected');
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name: 'Save the corrections file' }).click(),
    ]);
    const folder = join(home.folder, '..', 'corrections');
    await download.saveAs(join(folder, 'home_0001_corrections.json'));
    const [graph, edge] = [join(home.folder, 'connectivity/home_0001_connectivity.json'),
      JSON.parse(readFileSync(join(folder, 'home_0001_corrections.json'), 'utf8')).corrections[0]];
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

  it.each(['/', '/episodes', '/leaderboard', '/submit', '/organise', '/review', '/view#home_0001', '/verify#home_0001', '/view', '/verify#nowhere', '/view?split=val_seen&id=1_0'])(
    '%s keeps nobody out, at any width',
    async (path) => {
      const page = await openPage(home, path);
      await page.locator('h1').waitFor();
      await page.waitForLoadState('networkidle');
      await inspect(page, path.slice(1).replace(/\W+/g, '-') || 'index');
      await page.close();
    },
  );

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
