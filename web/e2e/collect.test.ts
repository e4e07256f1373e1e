/** People write instructions and walk them: the real server, database and homes; people by script. */
import { mkdirSync, readFileSync, symlinkSync, writeFileSync } from 'node:fs';
import { createServer, type Server } from 'node:http';
import type { AddressInfo } from 'node:net';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { distancesFrom } from '../src/distances.ts';
import type { Scan } from '../src/scan.ts';
import type { WalkTask } from '../src/work/walk_task.ts';
import { complaints, enfilade, type Home, inspect, keepScreenshot, makeCollection, missing, newToken, openHome, openPage, patience } from './harness.ts';

declare const window: { walkTask?: WalkTask };

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
    organiser = await openPage(home, '/organise');
    await organiser.getByLabel('Your token').fill(newToken(home, 'Ada', 'organiser'));
    await organiser.getByRole('button', { name: 'Log in' }).click();
    await organiser.getByText('There is none yet.').waitFor();
  });
  afterAll(async () => {
    await home?.stop();
  });

  const texts = { consent: '# Consent\n\nDo you agree?', instructions: `# Write\n\n**Look** ${script} around.` };

  /** A new worker, or one who comes again, up to the first task. */
  async function arrive(link: string, phone = false): Promise<Page> {
    const page = await openPage(home, link, phone);
    await page.getByRole('button', { name: 'I agree' }).click();
    await page.getByRole('button', { name: 'Begin' }).click();
    return page;
  }
  async function write(page: Page, text: string): Promise<void> {
    await page.getByLabel('Your directions').fill(text);
    const handIn = page.getByRole('button', { name: 'Hand in' });
    await handIn.click();
    await page.getByText('If it is right as it is').waitFor(); // the goal wasn't looked at
    await handIn.click();
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
    await organiser.getByText('More').click();
    await organiser.getByLabel(/lies still/).fill('1');
    await organiser.getByRole('button', { name: 'Make it' }).click();
    await organiser.getByText('The consent still says').waitFor();
    await organiser.getByLabel('Consent').fill('# About this study\n\nWe are the **tests** of Enfilade.');
    await organiser.getByRole('button', { name: 'Make it' }).click();
    await organiser.getByText('It is made.').waitFor();
    await organiser.getByText('0 of 6 handed in').waitFor();
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
    await first.getByRole('button', { name: 'Begin' }).click();
    await first.getByRole('button', { name: 'Play' }).waitFor();
    await first.getByRole('button', { name: 'On along the path' }).click();
    await first.getByText('Place 2 of 3').waitFor();
    await first.getByLabel('Your directions').fill('Go');
    await first.getByRole('button', { name: 'Hand in' }).click();
    await first.getByText('This is very short.').waitFor();
    await inspect(first, 'collect-task');
    await first.getByLabel('Your directions').fill('Go on, and then');
    await first.reload(); // before the pause after which the server has it
    const text = first.getByLabel('Your directions');
    await text.waitFor();
    expect(await text.inputValue()).toBe('Go on, and then');
    await write(first, directions(script));
    await inspect(first, 'collect-between');
    await first.getByRole('button', { name: 'The next one' }).click();
    await write(first, directions('A'));
    await first.getByRole('button', { name: 'The next one' }).click();
    await first.getByRole('heading', { name: 'Thank you' }).waitFor();
    await inspect(first, 'collect-done');
    await first.close();

    const second = await arrive(path, true);
    await second.getByRole('button', { name: 'Hand in' }).scrollIntoViewIfNeeded();
    expect((await second.locator('canvas').boundingBox())!.y).toBeGreaterThanOrEqual(0); // the picture stays in sight
    await keepScreenshot(second, 'collect-scrolled-phone');
    await write(second, directions('B'));
    await second.getByRole('button', { name: 'The next one' }).click();
    await write(second, directions('B'));
    await second.close();

    await new Promise((resolve) => setTimeout(resolve, Math.max(left + 62_000 - Date.now(), 0)));
    const third = await arrive(path);
    await write(third, directions('C'));
    await third.getByRole('button', { name: 'The next one' }).click();
    await write(third, directions('C'));
    await third.getByRole('button', { name: 'The next one' }).click();
    await third.getByRole('heading', { name: 'Thank you' }).waitFor();
    await third.close();
    await organiser.reload();
    await organiser.getByText('6 of 6 handed in: 0 accepted, 6 to review').waitFor();
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
    await reviewer.getByText('Say why.').waitFor();
    await reviewer.getByLabel('Why, if you reject it').fill('It leads elsewhere.');
    await reviewer.getByRole('button', { name: 'Reject' }).click();
    for (const place of ['3 of 6', '4 of 6', '5 of 6', '6 of 6']) {
      await reviewer.getByText(place).waitFor();
      await reviewer.getByRole('button', { name: 'Accept' }).click();
    }
    await reviewer.getByText('this was the last').waitFor();
    await reviewer.getByRole('combobox', { name: 'Show' }).selectOption('rejected');
    await reviewer.getByText('1 of 1').waitFor();
    await expect.poll(() => reviewer.getByLabel('Why, if you reject it').inputValue(), { timeout: patience }).toBe('It leads elsewhere.');
    await reviewer.close();
  });

  it('gives a rejected place to another worker, and is a data set then', async () => {
    await organiser.reload();
    await organiser.getByText('5 of 6 handed in').waitFor();
    const link = new URL(await organiser.getByLabel('Link for workers').inputValue());
    const fourth = await arrive(link.pathname + link.search);
    await write(fourth, directions('D'));
    await fourth.close();
    await organiser.goto(`${home.server}/review?collection=ways-through-a-flat`);
    await organiser.getByText('1 of 1').waitFor();
    await organiser.getByRole('button', { name: 'Accept' }).click();
    await organiser.getByText('this was the last').waitFor();

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
    const scan = (await (await fetch(`${home.server}/api/v1/scans/home_0001`)).json()) as Scan;
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
      await page.getByText(stay ? 'no bonus' : 'earns the bonus').waitFor();
      if (k === 0) await inspect(page, 'walk-between');
      await page.getByRole('button', { name: 'The next one' }).click();
    }
    await page.getByRole('heading', { name: 'Thank you' }).waitFor();
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

  it('is taken to Mechanical Turk: preview, frame, form', async () => {
    const forms: URLSearchParams[] = [];
    const turk = await standIn(forms);
    const origin = `http://127.0.0.1:${(turk.address() as AddressInfo).port}`;
    const link = await makeCollection(organiser, {
      name: 'turk', title: 'Directions', kind: 'write', ...texts, sources: [{ split: 'val_seen', most: 1 }],
      platform: { kind: 'mturk', origins: [origin] },
    });
    const show = async (parameters: Record<string, string>) => {
      const page = await home.browser.newPage();
      page.setDefaultTimeout(patience);
      await page.goto(`${origin}/?${new URLSearchParams({ show: `${home.server}${link}&${new URLSearchParams(parameters)}` })}`);
      return { page, frame: page.frameLocator('iframe') };
    };
    const preview = await show({ assignmentId: 'ASSIGNMENT_ID_NOT_AVAILABLE', hitId: 'H1' });
    await preview.frame.getByText('This is a preview').waitFor();
    expect(await preview.frame.getByRole('button', { name: 'Hand in' }).isDisabled()).toBe(true);
    await keepScreenshot(preview.page, 'turk-preview');
    await preview.page.close();

    const ids = { assignmentId: 'A1', hitId: 'H1', workerId: 'W1', turkSubmitTo: origin };
    const { page, frame } = await show(ids);
    await frame.getByRole('button', { name: 'I agree' }).click();
    await frame.getByRole('button', { name: 'Begin' }).click();
    await frame.getByLabel('Your directions').fill(directions('W'));
    await frame.getByRole('button', { name: 'Hand in' }).click();
    await frame.getByText('If it is right as it is').waitFor();
    await frame.getByRole('button', { name: 'Hand in' }).click();
    await frame.getByRole('button', { name: 'Hand in to Mechanical Turk' }).click();
    await frame.getByText('Taken by the stand-in').waitFor();
    expect(forms.map((form) => form.get('assignmentId'))).toEqual(['A1']);
    expect([...forms[0]!.keys()].length).toBeGreaterThan(1); // MTurk refuses a form of nothing else
    await page.close();
    await new Promise((resolve) => turk.close(resolve));
  });

  it('is taken to Prolific: ids in, completion code out', async () => {
    const link = await makeCollection(organiser, {
      name: 'prolific', title: 'Directions', kind: 'write', ...texts, sources: [{ split: 'val_seen', most: 1 }],
      platform: { kind: 'prolific', completion_code: 'C0DE42' },
    });
    const filled = link.replace('{{%PROLIFIC_PID%}}', 'p1').replace('{{%STUDY_ID%}}', 's1').replace('{{%SESSION_ID%}}', 'x1');
    const page = await arrive(filled);
    await write(page, directions('P'));
    await page.getByText('C0DE42').waitFor();
    expect(await page.getByRole('link', { name: 'Back to Prolific' }).getAttribute('href'))
      .toBe('https://app.prolific.com/submissions/complete?cc=C0DE42');
    await inspect(page, 'collect-prolific');
    await page.close();
  });

  it('keeps nobody out, whatever a worker comes to', async () => {
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
    await organiser.goto(`${home.server}/organise`);
    await organiser.getByRole('button', { name: 'Close: One way' }).click();
    await organiser.getByRole('button', { name: 'Open again: One way' }).waitFor();
    await inspect(organiser, 'organise-many');
    await first.getByRole('button', { name: 'The next one' }).click();
    await shown(first, 'This collection is closed', 'collect-closed');
    await first.close();
    await second.close();
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});

/** Runs in the page: turns to a neighbour, and says which of those ahead it is, from 1. */
function face(id: string): number {
  const { viewer } = window.walkTask!;
  const goal = viewer.scan.viewpoints.findIndex((v) => v.id === id);
  const at = (v: number) => viewer.scan.viewpoints[v]!.position;
  const [from, to] = [at(viewer.pose.viewpoint), at(goal)];
  viewer.look(Math.atan2(to[0] - from[0], to[1] - from[1]), 0);
  return viewer.steps().findIndex(({ viewpoint }) => viewpoint === goal) + 1;
}

/** Looks at a neighbour, and goes there by the key of its number in the list. */
async function stepTo(page: Page, id: string): Promise<void> {
  const number = await page.evaluate(face, id);
  await page.locator('canvas').focus();
  await page.keyboard.press(String(number));
  await page.waitForFunction((to) => {
    const { viewer } = window.walkTask!;
    return viewer.scan.viewpoints[viewer.pose.viewpoint]!.id === to;
  }, id);
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

/** What Mechanical Turk does with an ExternalQuestion: a frame, and an address for its form. */
async function standIn(forms: URLSearchParams[]): Promise<Server> {
  const server = createServer((request, response) => {
    const url = new URL(request.url!, 'http://stand-in');
    response.setHeader('Content-Type', 'text/html');
    if (request.method === 'GET') {
      const address = (url.searchParams.get('show') ?? '').replaceAll('&', '&amp;').replaceAll('"', '&quot;');
      response.end(`<!doctype html><title>Stand-in</title><iframe title="HIT" width="1000" height="700" src="${address}"></iframe>`);
      return;
    }
    let body = '';
    request.on('data', (chunk) => { body += String(chunk); });
    request.on('end', () => {
      if (url.pathname === '/mturk/externalSubmit') forms.push(new URLSearchParams(body));
      response.end('<p>Taken by the stand-in</p>');
    });
  });
  await new Promise<void>((resolve) => server.listen(0, '127.0.0.1', resolve));
  return server;
}
