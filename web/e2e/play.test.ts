/** A person walks an episode as a model does: by keys, with pictures, over a reload. */
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { download } from './browsers.ts';
import { complaints, enfilade, type Home, inspect, makeHomes, missing, newFolder, openPage, serve, writeAnnotations } from './harness.ts';

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

describe.skipIf(missing)('who walks as a model does', () => {
  let home: Home;
  let folder: string;
  let first: readonly Result[];

  beforeAll(async () => {
    folder = newFolder();
    const data = join(folder, 'homes');
    makeHomes(data);
    writeAnnotations(data);
    writeBack(data);
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
    expect(await page.getByRole('link', { name: 'See the path' }).getAttribute('href')).toBe('/view?split=val_seen&id=1_0');
    const [saved] = JSON.parse(readFileSync(await download(page.getByRole('link', { name: 'Save the result' }), join(folder, 'saved')), 'utf8')) as Result[];
    expect(saved).toEqual(first.find(({ instr_id }) => instr_id === '1_0'));
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
    const picture = page.getByRole('img', { name: /^Left, ahead, right and behind/ });
    await picture.waitFor();
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
    await page.getByRole('heading', { name: 'The episode is over' }).waitFor();
    await page.getByRole('button', { name: 'Walk it again' }).click();
    await stepsAre(page, 0);
    await page.close();
  });

  it('chooses an episode by a form', async () => {
    const page = await openPage(home, '/play');
    await page.getByLabel('Split').waitFor();
    await inspect(page, 'play-begin');
    await page.getByLabel('What you get').selectOption('marks');
    await page.getByRole('button', { name: 'Begin' }).click();
    await page.waitForURL(/split=val_seen&episode=\d_\d&view=marks/);
    await begun(page);
    await page.goto(home.server + address('77_0'));
    expect(await page.getByRole('alert').textContent()).toContain('no episode');
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
