/** What all pages have: the same header, nothing that moves while they are loaded, a word when something is wrong or the server is gone. */
import type { Page } from 'playwright-core';
import { describe, expect, it } from 'vitest';
import type { Viewer } from '../src/viewer/viewer.ts';
import { complaints, expectStill, type Home, inspect, missing, openPage, scan, watch, withHome } from './harness.ts';

declare const window: { enfilade?: { viewer: Viewer } };

/** Addresses, and what the navigation marks there. */
const everyPage = [
  ['/', 'Buildings'], [`/view#${scan}`, 'Buildings'], [`/verify#${scan}`, 'Buildings'], ['/view?split=val_seen&id=1_0', 'Buildings'],
  ['/episodes', 'Episodes'], ['/try?split=val_seen&id=1_0', 'Episodes'], ['/play', 'Episodes'],
  ['/play?split=val_seen&episode=1_0&view=marks', 'Episodes'], ['/leaderboard', 'Leaderboard'], ['/submission?id=99', 'Leaderboard'],
  ['/submit', 'Submit'], ['/organise', 'Collections'], ['/review', 'Collections'],
  ['/replay', 'Runs'], ['/replay?run=oracle', 'Runs'], ['/replay?run=oracle&episode=1_0#2', 'Runs'],
] as const;
/** Also the link that leads back. */
const wrongPages = [
  ['/view', 'Buildings', 'Buildings'], ['/view#nowhere', 'Buildings', 'Buildings'],
  ['/view?split=val_seen&id=nosuch', 'Buildings', 'Episodes of val_seen'], ['/verify#nowhere', 'Buildings', 'Buildings'],
  ['/roam#nowhere', 'Buildings', 'Buildings'], ['/try?split=val_seen&id=nosuch', 'Episodes', 'Episodes of val_seen'],
  ['/replay?run=nosuch', 'Runs', 'Runs'], ['/replay?run=oracle&episode=nosuch', 'Runs', 'oracle'],
] as const;

describe.skipIf(missing)('all pages', () => {
  let home: Home;
  withHome((opened) => { home = opened; });

  it('have the same navigation in the same place, whatever went wrong, and mark where one is', async () => {
    const frames: string[] = [];
    for (const phone of [true, false]) {
      frames.length = 0;
      for (const [path, name] of [...everyPage, ...wrongPages]) {
        const page = await openPage(home, path, phone);
        await page.locator('.site').getByText('Model homes: SYNTHETIC').waitFor();
        await page.locator('.site').getByRole('link', { name: 'Runs' }).waitFor();
        expect(await page.locator('.site [aria-current]').allTextContents(), path).toEqual([name]);
        frames.push(await page.evaluate(() => {
          const [header, nav] = [document.querySelector('.site')!, document.querySelector('.site-links')!];
          const links = [...nav.querySelectorAll('a')];
          const current = nav.querySelector('[aria-current]')!.getBoundingClientRect();
          const around = nav.getBoundingClientRect();
          const inSight = current.left >= around.left - 1 && current.right <= around.right + 1;
          const lines = new Set(links.map((link) => link.getBoundingClientRect().top)).size;
          const places = links.map(({ offsetLeft, offsetWidth }) => [offsetLeft, offsetWidth]);
          return JSON.stringify([header.getBoundingClientRect().height, places, lines, inSight]);
        }));
        await page.close();
      }
      expect(new Set(frames).size, frames.join('\n')).toBe(1);
      expect(frames[0]).toMatch(/,1,true\]$/);
    }
  });

  it('have a link past the navigation, which leaves the address as it is', async () => {
    for (const path of [`/view#${scan}`, '/replay?run=oracle&episode=1_0#2']) {
      const page = await openPage(home, path);
      await page.locator('main canvas').first().waitFor();
      await page.locator('.skip').focus();
      await page.keyboard.press('Enter');
      expect(await page.evaluate(() => document.activeElement?.id)).toBe('main');
      expect(await page.evaluate(() => location.hash), path).not.toBe('#main'); // which is no building, and no step
      await page.close();
    }
  });

  it.each(wrongPages)('%s names what is wrong, and a way back', async (path, _, name) => {
    const page = await openPage(home, path);
    const main = page.locator('main');
    await main.locator('h1').waitFor();
    const wrong = /(nowhere|nosuch)/.exec(path)?.[0];
    if (wrong) await main.getByText(wrong).first().waitFor();
    await main.getByRole('link', { name }).first().waitFor();
    await page.close();
  });

  it.each(everyPage.map(([path]) => path))('%s stands still while it is loaded', async (path) => {
    for (const phone of [false, true]) {
      const page = await openPage(home, path, phone);
      await page.locator('h1').first().waitFor();
      await page.waitForLoadState('networkidle');
      await expectStill(page);
      await page.close();
    }
  });

  it('say that the server does not answer, and go on when it does', async () => {
    const [view, list] = [await openPage(home, `/view#${scan}`), await openPage(home, '/episodes')];
    const line = (page: Page) => page.locator('[role=alert]', { hasText: 'The server does not answer. Trying again…' });
    await view.waitForFunction(() => window.enfilade !== undefined);
    await view.waitForLoadState('networkidle');
    await list.getByText('1 to 18 of 18').waitFor();
    const far = await view.evaluate(() => { // its pictures are not there yet
      const { viewer } = window.enfilade!;
      const kept = [viewer.pose.viewpoint, ...viewer.steps().map(({ viewpoint }) => viewpoint)];
      return viewer.scan.viewpoints.findIndex(({ rotation }, v) => rotation && !kept.includes(v));
    });
    expect(far).toBeGreaterThanOrEqual(0);
    await home.crash();
    expect(await view.evaluate((to) => window.enfilade!.viewer.go(to), far)).toBe(false);
    await line(view).waitFor();
    await list.getByLabel('Words in the instruction').fill('turn LEFT');
    await line(list).waitFor();
    await inspect(list, 'episodes-server-gone');
    await home.revive();
    await line(view).waitFor({ state: 'detached' });
    await line(list).waitFor({ state: 'detached' });
    await view.waitForFunction((to) => window.enfilade!.viewer.pose.viewpoint === to && !window.enfilade!.viewer.onTheWay, far);
    await list.getByText('1 to 6 of 6').waitFor();
    await Promise.all([view.close(), list.close()]);

    // A page whose first question gets no answer begins anew by itself.
    const late = await home.browser.newPage();
    watch(late);
    await late.route(/\/(api\/v1|healthz)/, (route) => route.abort());
    await late.goto(`${home.server}/leaderboard`);
    await line(late).waitFor();
    await late.getByRole('navigation', { name: 'Pages' }).waitFor();
    await late.unroute(/\/(api\/v1|healthz)/);
    await late.getByRole('heading', { name: 'Leaderboard' }).waitFor();
    await late.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
