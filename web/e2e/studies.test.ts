/** An organiser's day: three studies one after the other, about what people would name, to their review. The homes are SYNTHETIC. */
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { consentGap, instructionsText } from '../src/collecting/default_texts.ts';
import type { Preview } from '../src/collecting/new_collection.ts';
import { complaints, enfilade, type Home, inspect, missing, newFolder, newToken, openPage, patience, serve } from './harness.ts';
import { work } from './work_by_api.ts';

interface Path { readonly path_id: number; readonly scan: string; readonly heading: number; readonly path: string[]; readonly instructions: string[] }
interface Sent {
  readonly kind: string;
  readonly instructions: string;
  readonly sources: readonly { readonly split: string; readonly paths?: readonly Path[] }[];
}

declare const window: { fetch: typeof fetch; sent?: string };

/** Parts of a building, by which nobody asks for an object. */
const parts = /\b(door|doorway|door frame|archway|window|window frame|wall|floor|ceiling|stairs|banister|railing|roof|facade)$/;
const consent = '# About this study\n\nWe are the **tests** of Enfilade.';

describe.skipIf(missing)("an organiser's day", () => {
  let home: Home;
  let organiser: Page;
  let mine: Path[];
  const links: Record<string, string> = {};

  beforeAll(async () => {
    const folder = newFolder();
    const data = join(folder, 'homes');
    enfilade('homes', '-o', data, '--homes', '3', '--kind', 'flat', '--area', '60', '--size', '128', '--samples', '1', '--light', 'coarse',
      '--paths', '6', '--tasks', 'reverie');
    const known = JSON.parse(readFileSync(join(data, 'r2r/R2R_train.json'), 'utf8')) as Path[];
    mine = known.slice(0, 2).map((one, k) => ({ ...one, path_id: 900_001 + k, instructions: [] }));
    home = await serve(folder, data, join(folder, 'service.sqlite'));
    organiser = await openPage(home, `/organise#token=${newToken(home, 'Ada', 'organiser')}`);
    await organiser.getByRole('button', { name: 'Log in' }).click();
    await organiser.getByText('No collections yet.').waitFor();
  });
  afterAll(async () => {
    await home?.stop();
  });

  const form = () => organiser.locator('details.new', { hasText: 'New collection' });
  const field = (label: string) => form().getByLabel(label);
  const consentField = () => form().getByRole('textbox', { name: 'Consent', exact: true });
  const instructions = () => form().getByRole('textbox', { name: 'Instructions', exact: true });

  /** Nothing of the study before is in the form. */
  async function expectFresh(): Promise<void> {
    if ((await form().getAttribute('open')) === null) await organiser.getByText('New collection').click();
    for (const label of ['Title, for workers', 'Name, in links', 'Only the first paths of each', 'Pay, as workers read it']) {
      expect(await field(label).inputValue(), label).toBe('');
    }
    expect(await field('Also, or instead, a file of paths').evaluate((input: HTMLInputElement) => input.files!.length)).toBe(0);
    expect(await form().getByRole('checkbox', { checked: true }).count()).toBe(0);
    expect(await consentField().inputValue()).toContain(consentGap);
    expect(await instructions().inputValue()).toBe(instructionsText.write);
    expect(await field('Type of task').inputValue()).toBe('write');
  }

  /** Makes it, and finds its card marked and in sight. Returns what was sent. */
  async function create(title: string): Promise<Sent> {
    // In the page: WebDriver BiDi tells of no bodies.
    await organiser.evaluate(() => {
      const send = window.fetch;
      window.fetch = (to, init) => {
        if (init?.method === 'POST' && typeof to === 'string' && to.endsWith('/api/v1/collections')) window.sent = init.body as string;
        return send(to, init);
      };
    });
    await organiser.getByRole('button', { name: 'Create and open' }).click();
    const card = organiser.getByRole('listitem').filter({ hasText: title });
    await card.getByText('The collection is open.').waitFor();
    expect(await organiser.locator('.card.made').getByRole('heading', { level: 2 }).innerText()).toBe(title);
    const box = (await card.getByRole('heading', { level: 2 }).boundingBox())!;
    expect(box.y).toBeGreaterThanOrEqual(0);
    expect(box.y).toBeLessThan(organiser.viewportSize()!.height);
    expect(await form().getAttribute('open')).toBeNull();
    links[title] = await card.getByLabel('Link for workers').inputValue();
    return JSON.parse(await organiser.evaluate(() => window.sent!)) as Sent;
  }

  it('has previews with objects that a person would name', async () => {
    for (const kind of ['describe', 'dialogue']) {
      const preview = await organiser.evaluate(async (wanted) => {
        const answer = await fetch('/api/v1/collections/preview', {
          method: 'POST', headers: { 'X-Enfilade': '1', 'Content-Type': 'application/json' },
          body: JSON.stringify({ name: 'p', title: 'P', consent: 'c', instructions: 'i', kind: wanted, sources: [{ split: 'train', objects: 20 }] }),
        });
        return answer.json() as Promise<Preview>;
      }, kind);
      const names = preview.objects!.map(({ name }) => name);
      expect(names.length, kind).toBeGreaterThan(2);
      expect(names.filter((name) => parts.test(name)), kind).toEqual([]);
    }
  });

  it('begins with a study of objects, seen before it is made', async () => {
    await expectFresh();
    await field('Title, for workers').fill('Describe things');
    await field('Type of task').selectOption('describe');
    expect(await instructions().inputValue()).toBe(instructionsText.describe);
    await form().getByRole('checkbox', { name: /^train/ }).check();
    await field('Only the first paths of each').fill('3');
    await inspect(organiser, 'organise-groups');
    await organiser.getByRole('button', { name: 'Preview a task' }).click();
    const dialog = organiser.getByRole('dialog');
    await dialog.getByText('This is a preview').waitFor();
    await dialog.locator('canvas').waitFor();
    await dialog.getByRole('heading', { name: 'The object' }).waitFor();
    expect(await dialog.getByRole('button', { name: 'Submit' }).isDisabled()).toBe(true);
    await inspect(organiser, 'organise-preview');
    await organiser.keyboard.press('Escape');
    await dialog.waitFor({ state: 'detached' });
    await form().getByText(/It would have \d objects? on \d paths?: /).waitFor();
    const { collections } = await organiser.evaluate(async () => (await fetch('/api/v1/collections')).json()) as { collections: object[] };
    expect(collections).toEqual([]); // it made nothing
    await organiser.getByRole('button', { name: 'Create and open' }).click();
    await organiser.getByText('The consent still says').waitFor();
    await consentField().fill(consent);
    const sent = await create('Describe things');
    expect(sent.sources).toEqual([{ split: 'train', most: 3, objects: 1 }]);
    await inspect(organiser, 'organise-made');
  });

  it('goes on with a file, and keeps instructions that the organiser wrote', async () => {
    await expectFresh();
    await field('Title, for workers').fill('Write for my paths');
    await instructions().fill('Write for a robot of ours.');
    await field('Type of task').selectOption('walk');
    expect(await instructions().inputValue()).toBe('Write for a robot of ours.');
    await form().getByRole('button', { name: 'Replace them by the draft for this type' }).click();
    expect(await instructions().inputValue()).toBe(instructionsText.walk);
    await field('Type of task').selectOption('write');
    expect(await instructions().inputValue()).toBe(instructionsText.write);
    const buffer = Buffer.from(JSON.stringify(mine));
    await field('Also, or instead, a file of paths').setInputFiles({ name: 'mine.json', mimeType: 'application/json', buffer });
    await field("That file's split").fill('mine');
    await consentField().fill(consent);
    const sent = await create('Write for my paths');
    expect(sent.sources.map(({ split, paths }) => [split, paths?.map(({ path_id }) => path_id)])).toEqual([['mine', [900_001, 900_002]]]);
  });

  it('ends with a third, which has nothing of the others', async () => {
    await expectFresh();
    await field('Title, for workers').fill('Guide along');
    await field('Type of task').selectOption('guide');
    await form().getByRole('checkbox', { name: /^val_unseen/ }).check();
    await field('Only the first paths of each').fill('1');
    await organiser.getByRole('button', { name: 'Create and open' }).click();
    await organiser.getByText('The consent still says').waitFor(); // that of the study before does not count
    await consentField().fill(consent);
    const sent = await create('Guide along');
    expect(sent).toMatchObject({ kind: 'guide', instructions: instructionsText.guide, sources: [{ split: 'val_unseen', most: 1 }] });
    const splits = await organiser.evaluate(async () => {
      const { collections } = await (await fetch('/api/v1/collections')).json() as { collections: { splits: { split: string }[] }[] };
      return collections.map((one) => one.splits.map(({ split }) => split));
    });
    expect(splits).toEqual([['train'], ['mine'], ['val_unseen']]);
    // The newest is on top.
    expect(await organiser.locator('.card h2').allInnerTexts()).toEqual(['Guide along', 'Write for my paths', 'Describe things']);
  });

  it('has workers in all of them', async () => {
    const words = (text: string) => text.split(' ').map((word, k) => ({ word, start: k, end: k + 0.5 }));
    for (const who of ['Bea', 'Cy']) {
      const text = who === 'Bea' ? 'Go past the sofa and stop at the bed.' : 'Go past the sofa and wait at the desk.';
      const described = await work(links['Describe things']!, ({ object }) =>
        ({ instruction: `Go to the ${object!.name} and clean it, says ${who}.`, seconds: 9, flags: [] }));
      expect(described).toBeGreaterThan(0);
      expect(await work(links['Write for my paths']!, () => ({ instruction: text, seconds: 9, flags: [] }))).toBe(2);
    }
    const guided = await work(links['Guide along']!, ({ path }) => ({
      instruction: 'Leave the room and stop.', words: words('Leave the room and stop.'), spoken: false, seconds: 9, flags: [],
      steps: path!.map((viewpoint, seconds) => ({ viewpoint, heading: 0, elevation: 0, seconds })),
    }));
    expect(guided).toBe(1);
    await organiser.reload();
    const card = organiser.getByRole('listitem').filter({ hasText: 'Write for my paths' });
    await card.getByText('4 of 6 submitted: 0 accepted, 4 to review.').waitFor();
    expect(await card.locator('.chart.days').getAttribute('aria-label')).toMatch(/^4 tasks submitted and 0 reviewed from /);
    expect(await card.locator('.main').count()).toBe(1); // one primary button
    await card.getByRole('link', { name: 'Review 4' }).waitFor();
    await inspect(organiser, 'organise-day');
  });

  it('has a menu for the rest, by keys', async () => {
    const card = organiser.getByRole('listitem').filter({ hasText: 'Write for my paths' });
    await card.getByLabel('More: Write for my paths').focus();
    await organiser.keyboard.press('Enter');
    const entry = card.getByRole('button', { name: 'Make a copy' });
    await entry.waitFor();
    await inspect(organiser, 'organise-menu');
    await organiser.keyboard.press('Escape');
    expect(await entry.isVisible()).toBe(false);
    expect(await card.getByLabel('More: Write for my paths').evaluate((one) => one === document.activeElement)).toBe(true);
    await organiser.keyboard.press('Enter');
    await entry.focus();
    await organiser.keyboard.press('Enter');
    await card.getByLabel('Name of the new collection').waitFor();
    expect(await organiser.evaluate(() => document.activeElement?.textContent)).toBe('Make a copy');
    await card.getByRole('button', { name: 'Cancel' }).click();
    await card.getByLabel('More: Write for my paths').click();
    await card.getByRole('button', { name: 'Preview a task' }).click();
    await organiser.getByRole('dialog').getByText('This is a preview').waitFor();
    await organiser.getByRole('button', { name: 'Close the preview' }).click();
    await organiser.getByRole('dialog').waitFor({ state: 'detached' });
  });

  it('is reviewed in a table, many at once', async () => {
    await organiser.goto(`${home.server}/review?collection=write-for-my-paths`);
    await organiser.getByText('1 of 4').waitFor();
    const accept = (await organiser.getByRole('button', { name: 'Accept' }).boundingBox())!;
    expect(accept.y + accept.height).toBeLessThan(organiser.viewportSize()!.height); // above the fold
    await organiser.locator('.side').evaluate((side) => side.scrollTo(0, 10_000));
    expect(await organiser.getByRole('button', { name: 'Accept' }).isVisible()).toBe(true);
    expect((await organiser.getByRole('button', { name: 'Accept' }).boundingBox())!.y).toBeGreaterThan(0); // sticks
    await organiser.getByRole('link', { name: 'Table', exact: true }).click();
    await organiser.getByText('4 tasks of 4 that match.').waitFor();
    await inspect(organiser, 'review-table');
    await organiser.getByLabel('Search in all texts').fill('DESK');
    await organiser.getByText('2 tasks of 2 that match.').waitFor();
    await organiser.getByRole('link', { name: /on its path/ }).first().click();
    await organiser.getByText('1 of 1').waitFor();
    expect(await organiser.getByLabel('The directions').inputValue()).toContain('desk');
    await organiser.goto(`${home.server}/review?collection=write-for-my-paths&view=table&q=desk`);
    await organiser.getByText('2 tasks of 2 that match.').waitFor();
    await organiser.getByLabel('All shown that wait for review').check();
    await organiser.getByRole('button', { name: 'Reject 2' }).click();
    await organiser.getByText('A rejection needs a reason.').waitFor();
    await organiser.getByRole('button', { name: 'Accept 2' }).click();
    await organiser.getByText('2 tasks accepted.').waitFor();
    await organiser.getByLabel('Search in all texts').fill('');
    await organiser.getByText('4 tasks of 4 that match.').waitFor();
    expect(await organiser.locator('.texts .badge.good').count()).toBe(2);
    const [one] = await organiser.locator('.texts tbody input:enabled').all();
    await one!.check();
    await organiser.getByLabel('Why, if you reject them').fill('Too little of it.');
    await organiser.getByRole('button', { name: 'Reject 1' }).click();
    await organiser.getByText('1 task rejected.').waitFor();
    await organiser.getByRole('link', { name: 'One by one' }).click();
    await organiser.getByText('1 of 1').waitFor();
    await organiser.keyboard.press('a');
    await organiser.getByRole('heading', { name: 'All reviewed' }).waitFor();
    await inspect(organiser, 'review-done');
    await organiser.getByRole('link', { name: 'Agreement and checks' }).first().click();
    await organiser.getByText('Token F1 of texts of a path').waitFor();
    await organiser.getByText('Where they agree least').waitFor();
    await inspect(organiser, 'review-agreement');
  });

  it('gives each study its own data', async () => {
    const file = (name: string, split: string, state: string) => organiser.evaluate(async (path) => (await fetch(path)).text(),
      `/api/v1/collections/${name}/export?${new URLSearchParams({ split, state })}`);
    const written = JSON.parse(await file('write-for-my-paths', 'mine', 'accepted')) as Path[];
    expect(written.flatMap(({ instructions: texts }) => texts).length).toBe(3);
    for (const { path_id, path } of written) expect(mine.find((one) => one.path_id === path_id)!.path).toEqual(path);
    const described = JSON.parse(await file('describe-things', 'train', 'all')) as { objId: number; instructions: string[] }[];
    for (const text of described.flatMap(({ instructions: texts }) => texts)) {
      expect(/Go to the (.*) and clean it/.exec(text)![1]).not.toMatch(parts);
    }
    const guided = JSON.parse((await file('guide-along', 'val_unseen', 'all')).trim()) as { instruction: string };
    expect(guided.instruction).toBe('Leave the room and stop.');
  }, patience);

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
