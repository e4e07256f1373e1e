/** Errands with no mouse. That each control of every page can be reached is in every_page.test.ts. */
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { WalkTask } from '../src/work/walk_task.ts';
import { isFirefox } from './browsers.ts';
import { complaints, type Home, makeCollection, missing, newToken, openHome, openPage, patience, results } from './harness.ts';
import { expectReached, focused, tabTo } from './keys.ts';

declare const window: { walkTask?: WalkTask };

/** Gives a file to the control that has the focus, by the dialogue that a key opens. */
async function choose(page: Page, content: string): Promise<void> {
  const file = { name: 'results.json', mimeType: 'application/json', buffer: Buffer.from(content) };
  if (isFirefox) { // its dialogue cannot be answered by WebDriver BiDi
    await page.locator('input[type=file]:focus').setInputFiles(file);
    return;
  }
  const [dialogue] = await Promise.all([page.waitForEvent('filechooser'), page.keyboard.press('Enter')]);
  await dialogue.setFiles(file);
}

/** Runs in the page: the number in the list of the next place of a path; 0 if it does not lie ahead. */
function numberOf(id: string): number {
  const { viewer } = window.walkTask!;
  return viewer.steps().findIndex(({ viewpoint }) => viewer.scan.viewpoints[viewpoint]!.id === id) + 1;
}

/** Turns by the arrow keys until a place lies ahead, and goes there by its number. */
async function walkTo(page: Page, id: string): Promise<void> {
  await tabTo(page, /^Panorama/);
  let number = 0;
  for (let turns = 0; turns < 36 && number === 0; ++turns) {
    await page.keyboard.press('ArrowRight');
    number = await page.evaluate(numberOf, id);
  }
  await page.keyboard.press(String(number));
  await page.waitForFunction((to) => {
    const { viewer } = window.walkTask!;
    return viewer.scan.viewpoints[viewer.pose.viewpoint]!.id === to;
  }, id);
}

describe.skipIf(missing)('without a mouse', () => {
  let home: Home;
  let organiser: string;
  beforeAll(async () => {
    home = await openHome();
    organiser = newToken(home, 'Ada', 'organiser');
  });
  afterAll(async () => {
    await home?.stop();
  });
  async function loggedIn(path: string): Promise<Page> {
    const page = await openPage(home, path);
    await tabTo(page, /^Your token/);
    await page.keyboard.type(organiser);
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Log out' }).waitFor();
    return page;
  }

  it('an episode is found and seen', async () => {
    const page = await openPage(home, '/episodes');
    await tabTo(page, /^Words in the instruction/);
    await page.keyboard.type('turn left');
    await page.getByText('1 to 6 of 6').waitFor();
    await tabTo(page, /^1_1$/);
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Play' }).waitFor();
    await tabTo(page, /^Layer/);
    await page.keyboard.press('d'); // selects by the first letter: depth
    await expect.poll(() => page.getByRole('combobox', { name: 'Layer' }).inputValue(), { timeout: patience }).toBe('depth');
    await page.close();
  });

  it('an edge is corrected', async () => {
    const page = await openPage(home, '/verify#home0001');
    await page.getByLabel('Your name').waitFor();
    await tabTo(page, /^Your name/);
    await page.keyboard.type('Ada');
    await page.keyboard.press('Tab');
    await page.keyboard.type('a rope');
    await tabTo(page, /^Remove the edge/);
    await page.keyboard.press('Enter');
    await page.getByText('Correction added.').waitFor();
    await tabTo(page, /^Undo correction 1/);
    await page.keyboard.press('Space');
    await page.getByText('None yet.').waitFor();
    await page.close();
  });

  // Its keys go around whole pages, past their last controls: see expectReached().
  it.skipIf(isFirefox)('a collection is made, a path described, the work reviewed', async () => {
    const page = await loggedIn('/organise');
    await page.getByText('No collections yet.').waitFor();
    await tabTo(page, /^Title/);
    await page.keyboard.type('By keys');
    await tabTo(page, /val_seen/);
    await page.keyboard.press('Space');
    await tabTo(page, /^Only the first/);
    await page.keyboard.type('1');
    await tabTo(page, /^Consent/);
    await page.keyboard.press('Control+A');
    await page.keyboard.type('Do you agree?');
    await tabTo(page, /^Create and open/);
    await page.keyboard.press('Enter');
    await page.getByText('The collection is open.').waitFor();
    const link = new URL(await page.getByLabel('Link for workers').inputValue());

    const worker = await openPage(home, link.pathname + link.search);
    await worker.getByText('Do you agree?').waitFor();
    await expectReached(worker);
    await tabTo(worker, /^I agree$/);
    await worker.keyboard.press('Enter');
    await worker.getByRole('heading', { name: 'Write directions' }).waitFor();
    await tabTo(worker, /^Start$/);
    await worker.keyboard.press('Enter');
    await worker.getByText('Place 1 of 3').waitFor();
    await expectReached(worker);
    for (const place of ['2', '3']) {
      await tabTo(worker, /^Next along the path/);
      await worker.keyboard.press('Enter');
      await worker.getByText(`Place ${place} of 3`).waitFor();
    }
    await tabTo(worker, /^Panorama/);
    for (let k = 0; k < 12; ++k) await worker.keyboard.press('ArrowRight');
    await tabTo(worker, /^Your directions/);
    await worker.keyboard.type('Go on along the wall, then stop where the path ends.');
    await tabTo(worker, /^Submit/);
    await worker.keyboard.press('Enter'); // the goal was looked at: no advice
    await worker.getByRole('heading', { name: 'Thank you' }).waitFor(); // it was the only one: no press more
    await worker.close();

    await page.reload();
    await page.getByText('1 of 3 submitted').waitFor();
    await expectReached(page);
    await tabTo(page, /^Review 1/);
    await page.keyboard.press('Enter');
    await page.getByText('1 of 1').waitFor();
    await expectReached(page);
    await tabTo(page, /^Accept$/);
    await page.keyboard.press('Enter');
    await page.getByRole('heading', { name: 'All reviewed' }).waitFor();
    await page.close();
  });

  it('directions are walked to their end, and the walk is reviewed', async () => {
    const page = await loggedIn('/organise');
    const link = await makeCollection(page, {
      name: 'walk', title: 'Walk', kind: 'walk', consent: 'Do you agree?', instructions: 'Walk.', sources: [{ split: 'val_seen', most: 1 }],
    });
    const [{ path }] = JSON.parse(readFileSync(join(home.folder, 'r2r/R2R_val_seen.json'), 'utf8')) as [{ path: string[] }];
    const walker = await openPage(home, link);
    for (const button of [/^I agree$/, /^Start$/]) {
      await walker.getByRole('button', { name: button }).waitFor();
      await tabTo(walker, button);
      await walker.keyboard.press('Enter');
    }
    await walker.waitForFunction(() => window.walkTask !== undefined);
    await expectReached(walker);
    for (const id of path.slice(1)) await walkTo(walker, id);
    await tabTo(walker, /^Stop here/);
    await walker.keyboard.press('Enter');
    await walker.keyboard.press('Tab'); // from "Yes" to "Keep walking"
    await walker.keyboard.press('Enter');
    await walker.keyboard.press('Enter'); // "Stop here" has the focus again
    await walker.keyboard.press('Enter');
    await walker.getByRole('heading', { name: 'Received' }).waitFor();
    await expectReached(walker, true);
    await walker.close();

    await page.goto(`${home.server}/review?collection=walk`);
    await page.getByText('1 of 1').waitFor();
    await expectReached(page);
    await tabTo(page, /^Play$/);
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    // Backwards: by way of Firefox's own controls, beyond the page's last, its buttons would no longer hear Enter.
    await tabTo(page, /^Accept$/, 'Shift+Tab');
    await page.keyboard.press('Enter');
    await page.getByRole('heading', { name: 'All reviewed' }).waitFor();
    await page.close();
  });

  // As above.
  it.skipIf(isFirefox)('results are handed in, found on the leaderboard and withdrawn', async () => {
    const page = await openPage(home, '/submit');
    page.on('filechooser', () => undefined); // from now on no dialogue opens of its own, however late a test waits for it
    await page.getByLabel("The team's name").waitFor();
    await tabTo(page, /^The team's name/);
    await page.keyboard.type('Keys');
    await page.keyboard.press('Enter');
    await page.getByText('The team is created.').waitFor();
    await tabTo(page, /^Log in$/);
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Log out' }).waitFor();
    for (const [method, walk] of [['walks', true], ['stays', false]] as const) {
      await tabTo(page, /^Method/);
      await page.keyboard.press('Control+A');
      await page.keyboard.type(method);
      await tabTo(page, /^Results file/);
      await choose(page, await results(home, walk));
      await tabTo(page, /^Check and submit$/);
      await page.keyboard.press('Enter');
      await page.getByRole('row', { name: new RegExp(`${method}.*scored`) }).waitFor();
    }
    await tabTo(page, /^Leaderboard$/);
    await page.keyboard.press('Enter');
    await page.getByRole('cell', { name: 'walks' }).waitFor(); // the better of the two
    await tabTo(page, /^NE$/);
    await page.keyboard.press('Enter');
    await page.getByRole('columnheader', { name: 'NE' }).and(page.locator('[aria-sort=ascending]')).waitFor();
    expect((await page.evaluate(focused))?.name).toBe('NE');

    await page.goto(`${home.server}/submit`);
    await page.getByRole('row', { name: /walks/ }).waitFor();
    await expectReached(page);
    await tabTo(page, /^Withdraw 1$/);
    await page.keyboard.press('Enter');
    await page.keyboard.press('Enter'); // it asks first
    await page.getByRole('cell', { name: 'withdrawn' }).waitFor();
    await page.goto(`${home.server}/leaderboard`);
    await page.getByRole('cell', { name: 'stays' }).waitFor();
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
