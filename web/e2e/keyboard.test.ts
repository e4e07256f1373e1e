/** Every page with no mouse: each control can be reached, has a name and shows the focus; each errand can be done. */
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { complaints, type Home, missing, newToken, openHome, openPage } from './harness.ts';

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

  it.each(['/', '/episodes', '/leaderboard', '/submit', '/organise', '/view?split=val_seen&id=1_0', '/verify#home_0001'])(
    'every control of %s is reached, named and outlined',
    async (path) => {
      const page = await openPage(home, path);
      await page.locator('h1').waitFor();
      await page.waitForLoadState('networkidle');
      const found = await stops(page);
      expect(found.length).toBeGreaterThan(4);
      for (const stop of found) {
        expect(stop.name, `the name of a ${stop.tag}`).not.toBe('');
        expect(stop.outlined, `the focus on ${stop.name}`).toBe(true);
      }
      const controls = await page.locator('main').evaluate((main) =>
        [...main.querySelectorAll<HTMLElement>('button, input, select, textarea, a[href]')]
          .filter((one) => one.checkVisibility() && !one.matches(':disabled')).length);
      expect(found.length).toBeGreaterThanOrEqual(controls);
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
    await expect.poll(() => page.getByRole('combobox', { name: 'Show' }).inputValue()).toBe('depth');
    await page.close();
  });

  it('an edge is corrected', async () => {
    const page = await openPage(home, '/verify#home_0001');
    await page.getByLabel('Who you are').waitFor();
    await tabTo(page, /^Who you are/);
    await page.keyboard.type('Ada');
    await page.keyboard.press('Tab');
    await page.keyboard.type('a rope');
    await tabTo(page, /^Remove the edge/);
    await page.keyboard.press('Enter');
    await page.getByText('Noted.').waitFor();
    await tabTo(page, /^Undo correction 1/);
    await page.keyboard.press('Space');
    await page.getByText('None yet.').waitFor();
    await page.close();
  });

  it('a collection is made, a path described, the work reviewed', async () => {
    const page = await loggedIn('/organise');
    await page.getByText('There is none yet.').waitFor();
    await tabTo(page, /^Title/);
    await page.keyboard.type('By keys');
    await tabTo(page, /val_seen/);
    await page.keyboard.press('Space');
    await tabTo(page, /^Only the first/);
    await page.keyboard.type('1');
    await page.keyboard.press('Enter');
    await page.getByText('It is made.').waitFor();
    const link = new URL(await page.getByLabel('Link for workers').inputValue());

    const worker = await openPage(home, link.pathname + link.search);
    await worker.getByRole('heading', { name: 'About this study' }).waitFor();
    await tabTo(worker, /^I agree$/);
    await worker.keyboard.press('Enter');
    await worker.getByRole('heading', { name: 'Write directions' }).waitFor();
    await tabTo(worker, /^Begin$/);
    await worker.keyboard.press('Enter');
    await worker.getByText('Place 1 of 3').waitFor();
    for (const place of ['2', '3']) {
      await tabTo(worker, /^On along the path/);
      await worker.keyboard.press('Enter');
      await worker.getByText(`Place ${place} of 3`).waitFor();
    }
    await tabTo(worker, /^Panorama/);
    for (let k = 0; k < 12; ++k) await worker.keyboard.press('ArrowRight');
    await tabTo(worker, /^Your directions/);
    await worker.keyboard.type('Go on along the wall, then stop where the path ends.');
    await tabTo(worker, /^Hand in/);
    await worker.keyboard.press('Enter'); // the goal was looked at: no advice
    await worker.getByRole('heading', { name: 'Received' }).waitFor();
    await worker.close();

    await page.reload();
    await page.getByText('1 of 3 handed in').waitFor();
    await tabTo(page, /^Review$/);
    await page.keyboard.press('Enter');
    await page.getByText('1 of 1').waitFor();
    await tabTo(page, /^Accept$/);
    await page.keyboard.press('Enter');
    await page.getByText('this was the last').waitFor();
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
