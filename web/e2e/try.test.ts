/** Visitors follow an instruction: any one at each visit, of any set of homes; what is wrong in an address is said. */
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest';
import { anyEpisode, type Offer } from '../src/episodes/any_episode.ts';
import type { Viewer } from '../src/viewer/viewer.ts';
import {
  complaints, enfilade, type Home, inspect, missing, newData, newFolder, openPage, patience, serve, writeHiddenSplit,
} from './harness.ts';

declare const window: { walker?: { viewer: Viewer } };

const opened = (page: Page) => page.waitForFunction(() => window.walker !== undefined);
const hint = (page: Page) => page.getByText(/^No ring is in view\. The next viewpoint is /);

/** Three sets, as `enfilade homes` makes and splits them: with hidden goals in a part of the homes. */
const sets = [['1', '3'], ['2', '3'], ['3', '5']] as const;

describe.skipIf(missing)('visitors of three sets of homes', () => {
  let home: Home | undefined;
  afterEach(async () => {
    await home?.stop();
    home = undefined;
  });

  it.each(sets)('always get an instruction (seed %s, %s homes)', async (seed, count) => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    enfilade('homes', '-o', data, '--homes', count, '--seed', seed, '--kind', 'flat', '--area', '60', '--size', '64', '--samples', '1',
      '--light', 'coarse', '--paths', '6', '--tasks', 'r2r');
    home = await serve(folder, data, join(folder, 'service.sqlite'));
    const ask = async <T>(path: string): Promise<T> => (await fetch(`${home!.server}/api/v1/${path}`)).json() as Promise<T>;
    const offer = { ...await ask<Pick<Offer, 'scans'>>('scans'), ...await ask<Pick<Offer, 'splits'>>('splits?task=all') };
    const found = new Set<string>();
    for (let visit = 0; visit < 200; ++visit) {
      const episode = await anyEpisode(ask, offer);
      expect(episode, `visit ${visit}`).toBeDefined();
      expect(offer.splits.find(({ split }) => split === episode!.split)?.goals_hidden).toBe(false);
      found.add(`${episode!.split} ${episode!.id}`);
    }
    expect(found.size).toBeGreaterThan(3);
    const page = await openPage(home, '/try');
    for (let visit = 0; visit < 5; ++visit) {
      if (visit > 0) await page.goto(`${home.server}/try`);
      await opened(page);
      expect(await page.locator('.instruction').textContent()).not.toBe('');
      const query = new URL(page.url()).searchParams;
      const { episodes: [episode] } = await ask<{ episodes: { heading: number; start: string }[] }>(
        `splits/${query.get('split')}/episodes?${new URLSearchParams({ id: query.get('id')! })}`);
      const pose = await page.evaluate(() => {
        const { viewer } = window.walker!;
        return { id: viewer.scan.viewpoints[viewer.pose.viewpoint]!.id, heading: viewer.pose.heading, elevation: viewer.pose.elevation };
      });
      expect(pose.id).toBe(episode!.start);
      expect(pose.heading).toBeCloseTo(episode!.heading, 3); // an agent's rule: nothing is turned for the visitor
      expect(pose.elevation).toBe(0);
    }
    await page.close();
  }, patience * 3);
});

describe.skipIf(missing)('a visitor', () => {
  let home: Home;
  beforeAll(async () => {
    const { folder, data } = newData();
    writeHiddenSplit(data);
    home = await serve(folder, data, join(folder, 'service.sqlite'));
  });
  afterAll(async () => {
    await home?.stop();
  });

  it('reads where the next viewpoint is while no ring is in view, and turns there', async () => {
    const page = await openPage(home, '/try?split=val_seen&id=1_0');
    await opened(page);
    await page.evaluate(() => { // what is ahead lies below the picture
      const { viewer } = window.walker!;
      const { position } = viewer.scan.viewpoints[viewer.pose.viewpoint]!;
      const [x, y] = viewer.scan.viewpoints[viewer.scan.viewpoints[viewer.pose.viewpoint]!.neighbours[0]!]!.position;
      viewer.look(Math.atan2(x - position[0], y - position[1]), Math.PI / 6);
    });
    await hint(page).waitFor();
    expect(await hint(page).textContent()).toContain('below the picture');
    await inspect(page, 'try-hint');
    await page.getByRole('button', { name: 'Turn there' }).click();
    await hint(page).waitFor({ state: 'detached' });
    expect(await page.evaluate(() => window.walker!.viewer.steps().length)).toBeGreaterThan(0);
    expect(await page.evaluate(() => document.activeElement?.tagName)).toBe('CANVAS');
    await page.close();
  });

  it('follows an instruction in a building, and the next one is of the same', async () => {
    const page = await openPage(home, '/try?scan=home0001');
    await opened(page);
    expect(Object.fromEntries(new URL(page.url()).searchParams)).toMatchObject({ split: 'val_seen', scan: 'home0001' });
    await page.getByRole('button', { name: 'Stop here' }).click();
    await page.getByText(/^You walked 0\.0 m and stopped /).waitFor();
    await page.getByText('Success is to stop nearer than 3 m to the goal.').waitFor();
    expect(await page.evaluate(() => window.walker!.viewer.steps().length), 'the episode is over').toBe(0);
    await page.getByRole('link', { name: 'Next instruction' }).click();
    await page.getByRole('button', { name: 'Stop here' }).waitFor();
    expect(new URL(page.url()).searchParams.get('scan')).toBe('home0001');
    await page.close();
  });

  it.each([
    ['/try?split=val_seen&id=9_9', 'Split val_seen has no episode "9_9".', 'Episodes of val_seen'],
    ['/try?split=test&id=9_0', 'Split test keeps its goals secret', 'Any instruction'],
    ['/try?split=test', 'Split test has no instruction whose goal is open', 'Any instruction'],
    ['/try?scan=home0009', 'This server has no building "home0009".', 'Buildings'],
  ])('is told what is wrong in %s, with a way back', async (address, text, way) => {
    const page = await openPage(home, address);
    await page.getByText(text).waitFor();
    await page.locator('main').getByRole('link', { name: way }).waitFor();
    await page.getByRole('navigation', { name: 'Pages' }).waitFor();
    if (way === 'Buildings') await inspect(page, 'try-nothing');
    await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
