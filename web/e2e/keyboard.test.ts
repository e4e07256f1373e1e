/** Every page with no mouse: each control can be reached, has a name and shows the focus; each errand can be done. */
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { WalkTask } from '../src/work/walk_task.ts';
import { isFirefox } from './browsers.ts';
import { complaints, type Home, makeCollection, missing, newToken, openHome, openPage, patience, results } from './harness.ts';

declare const window: { walkTask?: WalkTask };

interface Stop {
  readonly name: string;
  readonly tag: string;
  readonly outlined: boolean;
}

/** Runs in the page: what has the focus; nothing if that is the page itself. */
function focused(): Stop | undefined {
  const element = document.activeElement as (HTMLElement & { labels?: NodeListOf<HTMLElement> }) | null;
  if (!element || element === document.body || element === document.documentElement) return undefined;
  const label = element.labels?.[0]?.textContent;
  const name = element.getAttribute('aria-label') ?? label ?? element.textContent ?? '';
  const { outlineStyle, outlineWidth } = getComputedStyle(element);
  return { name: name.trim(), tag: element.tagName, outlined: outlineStyle !== 'none' && Number.parseFloat(outlineWidth) >= 2 };
}

/** All that Tab comes to, in its order. */
async function stops(page: Page): Promise<Stop[]> {
  const found: Stop[] = [];
  for (let k = 0; k < 150; ++k) {
    await page.keyboard.press('Tab');
    const stop = await page.evaluate(focused);
    if (!stop) return found;
    found.push(stop);
  }
  throw new Error(`the focus does not leave the page: ${found.slice(-3).map(({ name }) => name).join(', ')}`);
}

/** Presses Tab until something of that name has the focus. */
async function tabTo(page: Page, name: RegExp): Promise<void> {
  const passed: string[] = [];
  for (let k = 0; k < 150; ++k) {
    await page.keyboard.press('Tab');
    const stop = await page.evaluate(focused);
    if (stop && name.test(stop.name)) return;
    passed.push(stop?.name ?? '(page)');
  }
  throw new Error(`Tab does not come to ${name}: ${[...new Set(passed)].join(', ')}`);
}

/**
 * Each control can be reached, has a name, and shows that it has the focus.
 * @param last whether this is the last that the test does there. After the last control Firefox gives the focus to its own, and WebDriver
 * BiDi cannot take it back.
 */
async function expectReached(page: Page, last = false): Promise<void> {
  if (isFirefox && !last) return;
  const found = await stops(page);
  expect(found.length).toBeGreaterThan(0);
  for (const stop of found) {
    expect(stop.name, `the name of a ${stop.tag}`).not.toBe('');
    expect(stop.outlined, `the focus on ${stop.name}`).toBe(true);
  }
  const controls = await page.locator('main').evaluate((main) =>
    [...main.querySelectorAll<HTMLElement>('button, input, select, textarea, a[href], summary')]
      .filter((one) => one.checkVisibility() && !one.matches(':disabled')).length);
  expect(found.length).toBeGreaterThanOrEqual(controls);
}

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

  it.each(['/', '/episodes', '/leaderboard', '/submit', '/organise', '/view?split=val_seen&id=1_0', '/try?split=val_seen&id=1_0', '/verify#home0001',
    '/replay', '/replay?run=oracle', '/replay?run=oracle&episode=1_0#2', '/play', '/play?split=val_seen&episode=1_0&view=marks'])(
    'every control of %s is reached, named and outlined',
    async (path) => {
      const page = await openPage(home, path);
      await page.locator('h1').waitFor();
      await page.waitForLoadState('networkidle');
      await expectReached(page, true);
      await page.close();
    },
  );

  it('an episode is found and seen', async () => {
    const page = await openPage(home, '/episodes');
    await tabTo(page, /^Words in the instruction/);
    await page.keyboard.type('turn left');
    await page.getByText('1 to 6 of 6').waitFor();
    await tabTo(page, /^1_1$/);
    await page.keyboard.press('Enter');
    await page.getByRole('button', { name: 'Play' }).waitFor();
    await tabTo(page, /^Show/);
    await page.keyboard.press('d'); // selects by the first letter: depth
    await expect.poll(() => page.getByRole('combobox', { name: 'Show' }).inputValue(), { timeout: patience }).toBe('depth');
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
    await worker.getByRole('heading', { name: 'Received' }).waitFor();
    await worker.close();

    await page.reload();
    await page.getByText('1 of 3 submitted').waitFor();
    await expectReached(page);
    await tabTo(page, /^Review$/);
    await page.keyboard.press('Enter');
    await page.getByText('1 of 1').waitFor();
    await expectReached(page);
    await tabTo(page, /^Accept$/);
    await page.keyboard.press('Enter');
    await page.getByText('this was the last').waitFor();
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
    await tabTo(page, /^Accept$/);
    await page.keyboard.press('Enter');
    await page.getByText('this was the last').waitFor();
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
