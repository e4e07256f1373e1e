/**
 * Every page, by a table: with axe-core, at both widths, in light and dark, and by keys alone. Screenshots of it make the contact sheet. A new
 * page needs a row here, which the last test sees to.
 */
import { mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import {
  complaints, enfilade, expectStill, type Home, inspect, makeCollection, missing, newToken, openHome, openPage, patience, pathsOf, results, scan,
} from './harness.ts';
import { expectReached } from './keys.ts';
import { ask, work } from './work_by_api.ts';

/** Addresses for everybody. The first part of an address is its page. */
const visitors = ['/', '/episodes', '/episodes?split=nosuch', '/leaderboard', '/submit', '/organise', '/review',
  `/view#${scan}`, '/view', '/view#nowhere', '/view?split=val_seen&id=1_0', `/verify#${scan}`, '/verify#nowhere', `/roam#${scan}`,
  '/try?split=val_seen&id=1_0', '/try?split=val_seen&id=nosuch', '/replay', '/replay?run=oracle', '/replay?run=oracle&with=stop',
  '/replay?run=oracle&episode=1_0#2', '/replay?run=oracle&episode=1_0&with=stop#2', '/replay?run=nosuch',
  '/play', '/play?split=val_seen&episode=1_0', '/play?split=val_seen&episode=1_0&view=marks', '/submission?id=1', '/submission?id=99'] as const;

/** Addresses for organisers and reviewers. */
const staff = ['/organise', '/review', '/review?collection=write', '/review?collection=describe', '/review?collection=write&view=table',
  '/review?collection=write&view=agreement'] as const;

/** Kinds of tasks, each with the page that workers have for it. */
const kinds = [
  ['write', 'collect'], ['describe', 'collect'], ['guide', 'collect'], ['walk', 'walk'], ['find', 'walk'], ['dialogue', 'walk'],
] as const;
type Kind = (typeof kinds)[number][0];

const pageOf = (address: string): string => /^\/(\w*)/.exec(address)![1] || 'index';
/** The name of a screenshot: "view-split-val_seen-id-1_0". */
const nameOf = (address: string): string => address.slice(1).replace(/\W+/g, '-').replace(/-$/, '') || 'index';

describe.skipIf(missing)('every page', () => {
  let home: Home;
  let token: string;
  const links = {} as Record<Kind, string>;

  beforeAll(async () => {
    home = await openHome();
    enfilade('ask', '--data', home.folder, '--split', 'val_seen', '--stand-in', 'stop', '-o', join(home.folder, '../runs/stop'));
    const { token: team } = await ask<{ token: string }>(`${home.server}/api/v1/teams`, 'POST', { name: 'Team' });
    await ask(`${home.server}/api/v1/submissions?phase=val_seen&method=walks`, 'POST', JSON.parse(await results(home, true)) as object, team);
    // SYNTHETIC: a lamp at the end of each path, where there is none.
    const lamp = { name: 'lamp#standing', visible_pos: [15], bbox2d: [[220, 140, 200, 200]] };
    mkdirSync(join(home.folder, 'reverie'), { recursive: true });
    const boxes = pathsOf(home.folder).map((path) => [`${scan}_${path.at(-1)!}`, { 7: lamp }] as const);
    writeFileSync(join(home.folder, 'reverie/BBoxes.json'), JSON.stringify(Object.fromEntries(boxes)));
    token = newToken(home, 'Ada', 'organiser');
    const organiser = await loggedIn('/organise');
    const make = async (kind: Kind, sources: object[], more: object = {}) => {
      links[kind] = await makeCollection(organiser, {
        name: kind, title: `To ${kind}`, kind, sources, consent: '# Consent\n\nDo you agree?',
        instructions: '# Your task\n\nRead this first.', ...more,
      });
    };
    const paths = [{ split: 'val_seen', most: 2 }];
    await make('write', paths);
    await make('describe', paths);
    await make('guide', paths, { language: 'en-US' });
    await make('walk', paths);
    await make('dialogue', paths);
    // Two texts of each to review; one description is then looked for.
    const answer = () => ({ instruction: 'Go past the sofa, then stop beside the lamp.', seconds: 60, flags: [] });
    for (const kind of ['write', 'describe'] as const) expect(await work(home.server + links[kind], answer), kind).toBeGreaterThan(0);
    const list = () => fetch('/api/v1/collections/describe/work').then((response) => response.json() as Promise<{ work: { task: number }[] }>);
    const { work: texts } = await organiser.evaluate(list);
    await ask(`${home.server}/api/v1/tasks/${texts[0]!.task}/review`, 'PUT', { verdict: 'accepted' }, token);
    await make('find', [{ collection: 'describe' }]);
    await organiser.close();
  });
  afterAll(async () => {
    await home?.stop();
  });

  async function loggedIn(address: string): Promise<Page> {
    const page = await openPage(home, `/organise#token=${token}`);
    await page.getByRole('button', { name: 'Log in' }).click();
    await page.getByRole('button', { name: 'Log out' }).waitFor();
    await page.goto(home.server + address);
    return page;
  }

  /** Looks at it, and goes through it by Tab. */
  async function check(page: Page, name: string): Promise<void> {
    await page.locator('h1').first().waitFor();
    await page.waitForLoadState('networkidle');
    await expectStill(page);
    await inspect(page, name);
    await expectReached(page, true);
    await page.close();
  }

  it.each(visitors)('%s is for everybody', async (address) => {
    await check(await openPage(home, address), nameOf(address));
  }, patience * 2);

  it.each(staff)('%s is for organisers and reviewers', async (address) => {
    await check(await loggedIn(address), `${nameOf(address)}-staff`);
  }, patience * 2);

  it.each(kinds)('a task to %s is for workers', async (kind, page) => {
    const consent = await openPage(home, `${links[kind]}&worker=keys`);
    expect(pageOf(links[kind])).toBe(page);
    const agree = consent.getByRole('button', { name: 'I agree' });
    await agree.waitFor();
    if (kind === 'write' || kind === 'walk') await inspect(consent, `${page}-${kind}-consent`);
    await agree.click();
    const start = consent.getByRole('button', { name: /^Start/ });
    await start.waitFor();
    if (kind === 'write' || kind === 'walk') await inspect(consent, `${page}-${kind}-instructions`);
    await start.click();
    await consent.locator('canvas').waitFor();
    await check(consent, `${page}-${kind}-task`);
  }, patience * 2);

  it('has a row', () => {
    const rows = new Set([...visitors.map(pageOf), ...staff.map(pageOf), ...kinds.map(([, page]) => page)]);
    const files = readdirSync(join(import.meta.dirname, '../pages')).filter((file) => file.endsWith('.html'))
      .map((file) => file.slice(0, -'.html'.length));
    // /styles is for developers: pages.test.ts has it.
    expect([...rows].sort()).toEqual(files.filter((name) => name !== 'styles').sort());
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
