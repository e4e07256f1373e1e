/** People write instructions and walk them: the real server, database and homes; people by script. */
import { mkdirSync, readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { distancesFrom } from '../src/scan/distances.ts';
import type { Scan } from '../src/scan/scan.ts';
import type { WalkTask } from '../src/work/walk_task.ts';
import type { WriteTask } from '../src/work/write_task.ts';
import { goBack } from './browsers.ts';
import { complaints, enfilade, type Home, inspect, keepScreenshot, makeCollection, missing, newToken, openHome, openPage, patience } from './harness.ts';
import { stepTo } from './walking.ts';

declare const window: { walkTask?: WalkTask; writeTask?: WriteTask };

interface Entry {
  readonly path_id: number;
  readonly path: string[];
  readonly instructions: string[];
}

const script = '<script>alert(1)</script>';
const directions = (who: string) => `Leave the room, turn left, go past the sofa and stop at the door. ${who} says so.`;

describe.skipIf(missing)('a collection', () => {
  let home: Home;
  let organiser: Page;
  beforeAll(async () => {
    home = await openHome();
    organiser = await openPage(home, `/organise#token=${newToken(home, 'Ada', 'organiser')}`); // as serve prints it
    await organiser.waitForURL(({ hash }) => hash === ''); // out of sight of others
    await organiser.getByRole('button', { name: 'Log in' }).click();
    await organiser.getByText('No collections yet.').waitFor();
  });
  afterAll(async () => {
    await home?.stop();
  });

  const texts = { consent: '# Consent\n\nDo you agree?', instructions: `# Write\n\n**Look** ${script} around.` };

  /** A new worker, or one who comes again, up to the first task. */
  async function arrive(link: string, phone = false): Promise<Page> {
    const page = await openPage(home, link, phone);
    await page.getByRole('button', { name: 'I agree' }).click();
    await page.getByRole('button', { name: 'Start' }).click();
    return page;
  }
  async function write(page: Page, text: string): Promise<void> {
    await page.getByLabel('Your directions').fill(text);
    const submit = page.getByRole('button', { name: 'Submit' });
    await submit.click();
    await page.getByText('If it is right as it is').waitFor(); // the goal wasn't looked at
    await submit.click();
    await page.getByRole('heading', { name: /Received|Thank you/ }).waitFor();
  }
  const files = (name: string, query: Record<string, string>): Promise<string> =>
    organiser.evaluate(async (path) => (await fetch(path)).text(),
      `/api/v1/collections/${name}/export?${new URLSearchParams(query)}`);

  it('is made on the page', async () => {
    await inspect(organiser, 'organise-new');
    await organiser.getByLabel('Title, for workers').fill('Ways through a flat');
    expect(await organiser.getByLabel('Name, in links').inputValue()).toBe('ways-through-a-flat');
    await organiser.getByRole('checkbox', { name: /val_seen/ }).check();
    await organiser.getByLabel('Only the first paths of each').fill('2');
    await organiser.getByText('More', { exact: true }).click();
    await organiser.getByLabel(/inactive task/).fill('1');
    await organiser.getByRole('button', { name: 'Create and open' }).click();
    await organiser.getByText('The consent still says').waitFor();
    await organiser.getByRole('textbox', { name: 'Consent', exact: true }).fill('# About this study\n\nWe are the **tests** of Enfilade.');
    await organiser.getByRole('button', { name: 'Create and open' }).click();
    await organiser.getByText('The collection is open.').waitFor();
    await organiser.getByText('0 of 6 submitted').waitFor();
  });

  it('is written by three workers, while one leaves half way', async () => {
    const link = new URL(await organiser.getByLabel('Link for workers').inputValue());
    const path = link.pathname + link.search;
    const leaver = await arrive(path);
    await leaver.getByLabel('Your directions').fill('I will be gone in');
    await leaver.getByText('Draft saved.').waitFor();
    const left = Date.now();
    await leaver.close();

    const first = await openPage(home, path);
    await first.getByRole('heading', { name: 'About this study' }).waitFor();
    await inspect(first, 'collect-consent');
    await first.getByRole('button', { name: 'I agree' }).click();
    await first.getByRole('heading', { name: 'Write directions' }).waitFor();
    await inspect(first, 'collect-instructions');
    await first.getByRole('button', { name: 'Start' }).click();
    await first.getByRole('button', { name: 'Play' }).waitFor();
    expect(await first.evaluate(turnToNext)).toBeLessThan(1e-3); // not at a wall
    await first.getByText('You have not looked around yet.').waitFor();
    await first.getByRole('button', { name: 'Next along the path' }).click();
    await first.getByText('Place 2 of 3').waitFor();
    await first.getByLabel('Your directions').fill('Go');
    await first.getByRole('button', { name: 'Submit' }).click();
    await first.getByText('This is too short to lead anybody').waitFor();
    expect(await first.getByRole('table').count()).toBe(0); // words beside the text, no table of faults
    await inspect(first, 'collect-refused');
    await first.getByLabel('Your directions').fill('Go on, then stop.');
    expect(await first.getByText('This is too short to lead anybody').count()).toBe(0);
    await first.getByRole('button', { name: 'Submit' }).click();
    await first.getByText('This is very short.').waitFor();
    await inspect(first, 'collect-task');
    await first.getByLabel('Your directions').fill('Go on, and then');
    await first.reload(); // before the pause after which the server has it
    const text = first.getByLabel('Your directions');
    await text.waitFor();
    expect(await text.inputValue()).toBe('Go on, and then');
    await write(first, directions(script));
    await inspect(first, 'collect-between');
    await first.getByRole('button', { name: 'Next' }).click();
    await write(first, directions('A'));
    await first.getByRole('heading', { name: 'Thank you' }).waitFor(); // at once: nothing is left
    await first.getByText('Your 2 tasks have been received.').waitFor();
    await inspect(first, 'collect-done');
    await first.close();

    const second = await arrive(path, true);
    await second.getByRole('button', { name: 'Submit' }).scrollIntoViewIfNeeded();
    expect((await second.locator('canvas').boundingBox())!.y).toBeGreaterThanOrEqual(0); // the picture stays in sight
    await keepScreenshot(second, 'collect-scrolled-phone');
    await write(second, directions('B'));
    await second.getByRole('button', { name: 'Next' }).click();
    await write(second, directions('B'));
    await second.close();

    await new Promise((resolve) => setTimeout(resolve, Math.max(left + 62_000 - Date.now(), 0)));
    const third = await arrive(path);
    await write(third, directions('C'));
    await third.getByRole('button', { name: 'Next' }).click();
    await write(third, directions('C'));
    await third.getByRole('heading', { name: 'Thank you' }).waitFor();
    await third.close();
    await organiser.reload();
    await organiser.getByText('6 of 6 submitted: 0 accepted, 6 to review').waitFor();
    await inspect(organiser, 'organise-progress');
  });

  it('is reviewed', async () => {
    const reviewer = await openPage(home, '/review');
    await reviewer.getByLabel('Your token').fill(newToken(home, 'Grace', 'reviewer'));
    await reviewer.getByRole('button', { name: 'Log in' }).click();
    await reviewer.getByRole('link', { name: 'Ways through a flat' }).click();
    await reviewer.getByText('1 of 6').waitFor();
    const text = reviewer.getByLabel('The directions');
    expect(await text.inputValue()).toContain(script);
    await text.fill(directions('A'));
    await reviewer.getByRole('button', { name: 'Save the correction' }).click();
    await reviewer.getByRole('cell', { name: directions(script) }).waitFor();
    await inspect(reviewer, 'review-work');
    await reviewer.getByRole('button', { name: 'Accept' }).click();
    await reviewer.getByText('2 of 6').waitFor();
    await reviewer.getByRole('button', { name: 'Reject' }).click();
    await reviewer.getByText('A rejection needs a reason.').waitFor();
    await reviewer.keyboard.press('Escape'); // from here on by keys alone
    await reviewer.keyboard.press('r');
    await reviewer.keyboard.type('It leads elsewhere.');
    await reviewer.keyboard.press('Enter');
    await reviewer.getByText('3 of 6').waitFor();
    // What stands in the box when it is accepted is what is accepted, also after a look at another one.
    const kept = `Go past the sofa, and stop at the door of the hall. ${script}`;
    await reviewer.getByLabel('The directions').fill(kept);
    await reviewer.keyboard.press('Escape');
    await reviewer.keyboard.press('n');
    await reviewer.keyboard.press('n'); // at once: the last that was asked for is shown
    await reviewer.getByText('5 of 6').waitFor();
    await reviewer.keyboard.press('p');
    await reviewer.getByText('4 of 6').waitFor();
    await reviewer.keyboard.press('p');
    await reviewer.getByText('3 of 6').waitFor();
    await expect.poll(() => reviewer.getByLabel('The directions').inputValue(), { timeout: patience }).toBe(kept);
    await reviewer.keyboard.press('a');
    await reviewer.getByText('4 of 6').waitFor();
    await reviewer.keyboard.press('p');
    await reviewer.getByRole('heading', { name: /^Task .* accepted/i }).waitFor();
    await expect.poll(() => reviewer.getByLabel('The directions').inputValue(), { timeout: patience }).toBe(kept);
    await reviewer.keyboard.press('n');
    for (const place of ['4 of 6', '5 of 6', '6 of 6']) {
      await reviewer.getByText(place).waitFor();
      await reviewer.getByRole('button', { name: 'Accept' }).click();
    }
    await reviewer.getByRole('heading', { name: 'All reviewed' }).waitFor();
    await reviewer.getByRole('combobox', { name: 'Show' }).selectOption('rejected');
    await reviewer.getByText('1 of 1').waitFor();
    await expect.poll(() => reviewer.getByLabel('Why, if you reject it').inputValue(), { timeout: patience }).toBe('It leads elsewhere.');
    await reviewer.getByRole('combobox', { name: 'Show' }).selectOption('all');
    await reviewer.getByText('1 of 6').waitFor();
    await reviewer.getByRole('combobox', { name: 'Worker' }).selectOption({ index: 1 });
    await reviewer.getByText('1 of 2').waitFor();
    await inspect(reviewer, 'review-worker');
    await goBack(reviewer);
    await reviewer.getByText('1 of 6').waitFor();
    await reviewer.close();
  });

  it('gives a rejected place to another worker, and is a data set then', async () => {
    await organiser.reload();
    await organiser.getByText('5 of 6 submitted').waitFor();
    const link = new URL(await organiser.getByLabel('Link for workers').inputValue());
    const fourth = await arrive(link.pathname + link.search);
    await write(fourth, directions('D'));
    await fourth.close();
    await organiser.goto(`${home.server}/review?collection=ways-through-a-flat`);
    await organiser.getByText('1 of 1').waitFor();
    await organiser.getByRole('button', { name: 'Accept' }).click();
    await organiser.getByRole('heading', { name: 'All reviewed' }).waitFor();

    const text = await files('ways-through-a-flat', { split: 'val_seen', what: 'annotations' });
    const annotations = JSON.parse(text) as Entry[];
    expect(annotations.map(({ instructions }) => instructions.length)).toEqual([3, 3]);
    for (const { instructions } of annotations) expect(new Set(instructions).size).toBe(3); // of three workers
    const data = join(home.folder, '..', 'collected');
    mkdirSync(join(data, 'r2r'), { recursive: true });
    symlinkSync(join(home.folder, 'connectivity'), join(data, 'connectivity'));
    writeFileSync(join(data, 'r2r/R2R_val_seen.json'), text);
    const statistics = JSON.parse(enfilade('stats', '--data', data, '--split', 'val_seen', '--json', '-')) as
      { all: { paths: number; instructions: number } };
    expect(statistics.all).toMatchObject({ paths: 2, instructions: 6 });
  });

  it('is walked as an agent walks, and scored', async () => {
    const link = await makeCollection(organiser, { name: 'human', title: 'Follow directions', kind: 'walk', ...texts, sources: [{ split: 'val_seen', most: 4 }] });
    expect(link).toContain('/walk?');
    const annotations = JSON.parse(readFileSync(join(home.folder, 'r2r/R2R_val_seen.json'), 'utf8')) as Entry[];
    const scan = (await (await fetch(`${home.server}/api/v1/scans/home0001`)).json()) as Scan;
    const index = (id: string) => scan.viewpoints.findIndex((v) => v.id === id);
    const page = await arrive(link);
    let stays = 0;
    let reloads = 0;
    for (let k = 0; k < 12; ++k) {
      await page.waitForFunction(() => window.walkTask !== undefined);
      const start = await page.evaluate(() => {
        const { viewer } = window.walkTask!;
        return viewer.scan.viewpoints[viewer.pose.viewpoint]!.id;
      });
      const { path } = annotations.find((one) => one.path[0] === start)!;
      if (k === 0) {
        expect(await page.evaluate(seesAsAnAgent)).toEqual({ zoomed: false, least: true, tilted: true });
        await inspect(page, 'walk-task');
      }
      const stay = stays < 2 && distancesFrom(scan, index(path.at(-1)!))[index(start)]! >= 3; // two of twelve don't find it
      if (stay) stays += 1;
      else for (const id of path.slice(1)) await stepTo(page, id);
      if (!stay && reloads++ === 0) {
        await page.waitForTimeout(2500); // the server has it
        await page.reload();
        await page.waitForFunction((id) => {
          const viewer = window.walkTask?.viewer;
          return viewer?.scan.viewpoints[viewer.pose.viewpoint]!.id === id;
        }, path.at(-1)!);
      }
      await page.getByRole('button', { name: 'Stop here' }).click();
      if (k === 0) await inspect(page, 'walk-stop');
      await page.evaluate(() => { window.walkTask = undefined as never; });
      await page.getByRole('button', { name: 'Yes, this is the goal' }).click();
      if (k === 11) break;
      await page.getByText(`You have submitted ${k + 1} of 12.`).waitFor();
      expect(await page.locator('main').innerText()).not.toMatch(/bonus|goal|\d m\b/); // it would help with another
      if (k === 0) await inspect(page, 'walk-between');
      await page.getByRole('button', { name: 'Next' }).click();
    }
    await page.getByRole('heading', { name: 'Thank you' }).waitFor();
    await page.getByText('10 of your walks earned the bonus').waitFor(); // now it helps with nothing
    await inspect(page, 'walk-done');
    await page.close();
    const folder = join(home.folder, '..');
    for (const what of ['annotations', 'results', 'walks']) {
      writeFileSync(join(folder, `${what}.json`), await files('human', { split: 'val_seen', what, state: 'all' }));
    }
    const score = JSON.parse(enfilade('score', join(folder, 'results.json'), '--annotations', join(folder, 'annotations.json'),
      '--connectivity', join(home.folder, 'connectivity'), '--json', '-')) as { means: { success: { mean: number } } };
    expect(stays).toBe(2);
    expect(score.means.success.mean).toBeCloseTo(10 / 12, 6);
  });

  it('is reviewed walk by walk', async () => {
    await organiser.goto(`${home.server}/review?collection=human`);
    await organiser.getByText('1 of 12').waitFor();
    await organiser.getByText(/stopped (within 3 m of|3 m or more from) the goal/).waitFor();
    expect(await organiser.locator('.enfilade-map .walk').count()).toBe(1);
    await inspect(organiser, 'review-walk');
    await organiser.getByRole('button', { name: 'Accept' }).click();
    await organiser.getByText('2 of 12').waitFor();
  });

  it('is accessible, whatever a worker comes to', async () => {
    const shown = async (page: Page, text: string, name: string) => {
      await page.getByText(text).first().waitFor();
      await inspect(page, name);
    };
    const source = { ...texts, title: 'Ways', sources: [{ split: 'val_seen', most: 1 }], per_item: 1 };
    for (const kind of ['write', 'walk']) {
      const link = await makeCollection(organiser, { ...source, name: `preview-${kind}`, kind, platform: { kind: 'mturk' } });
      const preview = await openPage(home, `${link}&assignmentId=ASSIGNMENT_ID_NOT_AVAILABLE`);
      await shown(preview, 'This is a preview', `${kind}-preview`);
      await preview.close();
    }
    const link = await makeCollection(organiser, { ...source, name: 'one', title: 'One way', kind: 'write' });
    const stranger = await openPage(home, link.replace(/key=\w+/, 'key=0'));
    await shown(stranger, 'its key is wrong', 'collect-wrong-key');
    await stranger.goto(`${home.server}/walk`);
    await shown(stranger, 'This link names no collection', 'walk-no-name');
    await stranger.goto(home.server + link);
    await stranger.getByRole('button', { name: 'I do not agree' }).click();
    await shown(stranger, 'Nothing was kept', 'collect-declined');
    await stranger.close();

    const first = await arrive(link);
    await first.getByLabel('Your directions').waitFor();
    const second = await arrive(link);
    await shown(second, 'Others are at work', 'collect-wait');
    await write(first, directions('A'));
    await second.getByRole('button', { name: 'Try again' }).click();
    await shown(second, 'nothing more for you', 'collect-nothing');
    await shown(first, 'Your work has been received.', 'collect-only');
    const third = await openPage(home, link);
    await third.getByRole('button', { name: 'I agree' }).click();
    await third.getByRole('button', { name: 'Start' }).waitFor();
    await organiser.goto(`${home.server}/organise`);
    await organiser.getByLabel('More: One way').click();
    await organiser.getByRole('button', { name: 'Close: One way' }).click();
    await organiser.getByText('Closed.').waitFor();
    await organiser.getByLabel('More: One way').click();
    await organiser.getByRole('button', { name: 'Open again: One way' }).waitFor();
    await organiser.keyboard.press('Escape');
    await inspect(organiser, 'organise-many');
    await third.getByRole('button', { name: 'Start' }).click();
    await shown(third, 'This collection is closed', 'collect-closed');
    for (const page of [first, second, third]) await page.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});

/** Runs in the page: the angle between the view and the next viewpoint of the path, radians. */
function turnToNext(): number {
  const { viewer } = window.writeTask!;
  const at = (v: number) => viewer.scan.viewpoints[v]!.position;
  const [from, to] = [at(viewer.pose.viewpoint), at(viewer.nextOnPath!)];
  const difference = Math.atan2(to[0] - from[0], to[1] - from[1]) - viewer.pose.heading;
  return Math.abs(Math.atan2(Math.sin(difference), Math.cos(difference)));
}

/** Runs in the page: no zoom, no ring outside of the view, no look straight up. */
function seesAsAnAgent(): object {
  const { viewer } = window.walkTask!;
  const { pose } = viewer;
  viewer.zoom(0.5);
  const zoomed = viewer.pose.vfov !== pose.vfov;
  const least = viewer.steps().every(({ relHeading }) => Math.abs(relHeading) <= (40 * Math.PI) / 180 + 1e-4);
  viewer.look(pose.heading, 1.5);
  const tilted = Math.abs(viewer.pose.elevation - Math.PI / 6) < 1e-6;
  viewer.look(pose.heading, 0);
  return { zoomed, least, tilted };
}
