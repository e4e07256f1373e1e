/** People describe objects and find them, guide each other, and talk: the real server and homes, people by script. */
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import type { Viewer } from '../src/viewer/viewer.ts';
import { complaints, type Home, inspect, keepScreenshot, makeCollection, missing, newToken, openHome, openPage, patience } from './harness.ts';
import { stepTo } from './walking.ts';

declare const window: { walkTask?: { readonly viewer: Viewer }; writeTask?: { readonly viewer: Viewer }; heard?: (text: string) => void };

interface Path {
  readonly path_id: number;
  readonly path: string[];
}

/** MatterSim's view 15 looks along heading 90 degrees; the box is in its middle. */
const lamp = { name: 'lamp#standing', visible_pos: [15], bbox2d: [[220, 140, 200, 200]] };
const east = Math.PI / 2;

describe.skipIf(missing)('collections of', () => {
  let home: Home;
  let organiser: Page;
  let paths: Path[];
  beforeAll(async () => {
    home = await openHome();
    paths = JSON.parse(readFileSync(join(home.folder, 'r2r/R2R_val_seen.json'), 'utf8')) as Path[];
    const boxes = Object.fromEntries(paths.map(({ path }) => [`home0001_${path.at(-1)}`, { 7: lamp }]));
    mkdirSync(join(home.folder, 'reverie'), { recursive: true });
    writeFileSync(join(home.folder, 'reverie/BBoxes.json'), JSON.stringify(boxes)); // SYNTHETIC, and no lamp is there
    organiser = await openPage(home, `/organise#token=${newToken(home, 'Ada', 'organiser')}`);
    await organiser.getByRole('button', { name: 'Log in' }).click();
    await organiser.getByText('No collections yet.').waitFor();
  });
  afterAll(async () => {
    await home?.stop();
  });

  const texts = { consent: '# Consent\n\nDo you agree?', instructions: '# Your task\n\nRead this first.' };
  const source = (more: object = {}) => [{ split: 'val_seen', most: 1, ...more }];
  async function arrive(link: string, worker: string): Promise<Page> {
    const page = await openPage(home, `${link}&worker=${worker}`);
    await page.getByRole('button', { name: 'I agree' }).click();
    await page.getByRole('button', { name: 'Start' }).click();
    return page;
  }
  const file = (name: string, query: Record<string, string> = {}): Promise<string> =>
    organiser.evaluate(async (path) => (await fetch(path)).text(),
      `/api/v1/collections/${name}/export?${new URLSearchParams({ split: 'val_seen', ...query })}`);
  const seesMark = (page: Page) => page.locator('.enfilade-outlines circle:not([hidden])').waitFor({ state: 'attached' });
  const seesFrame = (page: Page) => page.locator('.enfilade-outlines polygon:not([hidden])').waitFor({ state: 'attached' });

  it('any kind are made on the page', async () => {
    await organiser.getByLabel('Type of task').selectOption('dialogue');
    await organiser.getByLabel('Objects at the end of each path').waitFor();
    await organiser.getByLabel('Type of task').selectOption('find');
    await organiser.getByLabel('Descriptions of this collection').waitFor();
    await organiser.getByLabel('Type of task').selectOption('guide');
    await organiser.getByLabel('Language').selectOption('te-IN');
    await organiser.getByLabel('Type of task').selectOption('describe');
    await organiser.getByLabel('Title, for workers').fill('Describe a lamp');
    await organiser.getByRole('textbox', { name: 'Consent', exact: true }).fill('# About this study\n\nWe are the **tests** of Enfilade.');
    await organiser.getByRole('checkbox', { name: /val_seen/ }).check();
    await organiser.getByLabel('Only the first paths of each').fill('1');
    await inspect(organiser, 'organise-describe');
    await organiser.getByRole('button', { name: 'Create and open' }).click();
    await organiser.getByText('The collection is open.').waitFor();
    await organiser.getByText('0 of 3 submitted').waitFor();
  });

  it('objects: one person describes, another walks and points, as for REVERIE', async () => {
    const link = new URL(await organiser.getByLabel('Link for workers').inputValue());
    const writer = await arrive(link.pathname + link.search, 'writer');
    await writer.getByText('The object is not seen from here.').waitFor();
    for (const place of ['Place 2 of 3', 'Place 3 of 3']) {
      await writer.getByRole('button', { name: 'Next along the path' }).click();
      await writer.getByText(place).waitFor();
    }
    await writer.getByText('The object is in the view').waitFor(); // one arrives looking at it
    for (const turn of [1, 2, Math.PI]) await writer.evaluate((heading) => window.writeTask!.viewer.look(heading, 0), east + turn);
    await writer.getByText(/Turn (left|right) to see the object/).waitFor();
    await writer.getByRole('button', { name: 'Look at it' }).click();
    await seesFrame(writer);
    await writer.getByText('The object is in the view').waitFor();
    expect(await writer.evaluate((heading) => Math.abs(window.writeTask!.viewer.pose.heading - heading), east)).toBeLessThan(0.02);
    await writer.getByText('You have looked around at 1 of them.').waitFor();
    await writer.getByLabel('Your request').fill('Go to the end of the hall and switch on the lamp beside the window.');
    await inspect(writer, 'describe-task');
    await writer.getByRole('button', { name: 'Submit' }).click(); // the goal was looked at: no advice
    await writer.getByRole('heading', { name: /Received|Thank you/ }).waitFor();
    await writer.close();
    await organiser.goto(`${home.server}/review?collection=describe-a-lamp`);
    await organiser.getByText('1 of 1').waitFor();
    await organiser.getByLabel('The directions').waitFor();
    await inspect(organiser, 'review-describe');
    await organiser.getByRole('button', { name: 'Accept' }).click();
    await organiser.getByRole('heading', { name: 'All reviewed' }).waitFor();
    const [entry] = JSON.parse(await file('describe-a-lamp')) as { id: string; objId: number; path: string[]; instructions: string[] }[];
    expect(entry).toMatchObject({ id: `${paths[0]!.path_id}_7`, objId: 7, path: paths[0]!.path });

    const find = await makeCollection(organiser, { ...texts, name: 'find-a-lamp', title: 'Find a lamp', kind: 'find', sources: [{ collection: 'describe-a-lamp' }] });
    expect(find).toContain('/walk?');
    const finder = await arrive(find, 'finder');
    await finder.waitForFunction(() => window.walkTask !== undefined);
    await finder.getByText(entry!.instructions[0]!).waitFor();
    for (const id of paths[0]!.path.slice(1)) await stepTo(finder, id);
    await finder.getByRole('button', { name: 'I see the object' }).click();
    const yes = finder.getByRole('button', { name: 'Yes, this is the object' });
    expect(await yes.getAttribute('aria-disabled')).toBe('true');
    await finder.evaluate((heading) => window.walkTask!.viewer.look(heading, 0), east + 0.2);
    await finder.keyboard.press('Enter'); // the focus is on "Point at the middle"
    await seesMark(finder);
    for (let k = 0; k < 6; ++k) await finder.keyboard.press('ArrowLeft');
    await finder.evaluate((heading) => window.walkTask!.viewer.look(heading, 0), east);
    await finder.locator('canvas').click({ position: { x: 300, y: 200 } }); // by the mouse it goes elsewhere
    await finder.getByRole('button', { name: 'Point at the middle' }).click();
    await inspect(finder, 'find-point');
    await yes.click();
    await finder.getByRole('heading', { name: /Received|Thank you/ }).waitFor();
    await finder.close();
    const [result] = JSON.parse(await file('find-a-lamp', { what: 'results' })) as { instr_id: string; predObjId: number }[];
    expect(result).toMatchObject({ instr_id: `${entry!.id}_0`, predObjId: 7 });
    await organiser.goto(`${home.server}/review?collection=find-a-lamp`);
    await organiser.getByText('pointed at the object').waitFor();
    await inspect(organiser, 'review-find');
    expect(await organiser.locator('.enfilade-outlines circle:not([hidden])').count()).toBe(0); // it belongs to the end of the walk
    await organiser.goto(`${home.server}/review?collection=describe-a-lamp&state=accepted`);
    await organiser.getByText('1 of 1 who looked for it found it').waitFor();
  });

  it('guides: words with their times, typed and spoken, as for RxR', async () => {
    const link = await makeCollection(organiser, { ...texts, name: 'guide', title: 'Guide another person', kind: 'guide', language: 'en-IN', sources: source() });
    const page = await openPage(home, `${link}&worker=guide`);
    await page.addInitScript(() => {
      // A stand-in for the browser's own, which asks its maker: it hears what the test says.
      class Recognition {
        onresult?: (heard: object) => void;
        onspeechstart?: () => void;
        onend?: () => void;
        start(): void {
          window.heard = (text) => {
            this.onspeechstart?.();
            setTimeout(() => this.onresult?.({ resultIndex: 0, results: [Object.assign([{ transcript: text }], { isFinal: true })] }), 300);
          };
        }
        stop(): void {
          this.onend?.();
        }
      }
      Object.assign(window, { SpeechRecognition: Recognition });
    });
    await page.reload();
    await page.getByRole('button', { name: 'I agree' }).click();
    await page.getByRole('button', { name: 'Start' }).click();
    const text = page.getByLabel('Say it as you go');
    await text.pressSequentially('Leave this room ');
    await page.getByRole('button', { name: 'Submit' }).click();
    await page.getByText('Walk the path to its end').waitFor();
    await page.getByRole('button', { name: 'Next along the path' }).click();
    await page.getByText('Place 2 of 3').waitFor();
    await page.waitForTimeout(2500); // the server has the step, too
    await page.reload();
    await expect.poll(() => text.inputValue(), { timeout: patience }).toBe('Leave this room ');
    await page.getByText('Place 2 of 3').waitFor(); // one goes on where one was
    await page.getByRole('button', { name: 'Speak' }).click();
    await page.evaluate(() => window.heard!('and go past the sofa'));
    await expect.poll(() => text.inputValue(), { timeout: patience }).toBe('Leave this room and go past the sofa');
    await inspect(page, 'guide-task');
    await page.getByRole('button', { name: 'Stop speaking' }).click();
    await page.getByRole('button', { name: 'Next along the path' }).click();
    await page.getByText('Place 3 of 3').waitFor();
    await text.press('End');
    await text.pressSequentially(' to the door.');
    await page.getByRole('button', { name: 'Submit' }).click();
    await page.getByRole('heading', { name: /Received|Thank you/ }).waitFor();
    await page.close();
    await organiser.goto(`${home.server}/review?collection=guide`);
    await organiser.getByText('spoken, at least in part').waitFor();
    await organiser.getByText('Words and their times').click();
    await organiser.getByRole('cell', { name: 'sofa' }).waitFor();
    await inspect(organiser, 'review-guide');
    const line = JSON.parse(await file('guide', { state: 'all' })) as { language: string; instruction: string; timed_instruction: { word: string; start_time: number; end_time: number }[] };
    expect(line).toMatchObject({ language: 'en-IN', instruction: 'Leave this room and go past the sofa to the door.' });
    expect(line.timed_instruction.map(({ word }) => word).join(' ')).toBe(line.instruction);
    line.timed_instruction.forEach(({ start_time, end_time }, k, all) => {
      expect(end_time).toBeGreaterThanOrEqual(start_time);
      expect(start_time).toBeGreaterThanOrEqual(all[k - 1]?.start_time ?? 0);
    });
    const [trace] = JSON.parse(await file('guide', { state: 'all', what: 'walks' })) as { steps: { viewpoint: string }[] }[];
    expect(new Set(trace!.steps.map(({ viewpoint }) => viewpoint))).toEqual(new Set(paths[0]!.path));
  });

  it('dialogues: a navigator and an oracle at two browsers, as for CVDN', async () => {
    const link = await makeCollection(organiser, { ...texts, name: 'dialogue', title: 'Find it together', kind: 'dialogue', sources: source() });
    const navigator = await arrive(link, 'navigator');
    await navigator.getByRole('heading', { name: 'You are the navigator' }).waitFor();
    await navigator.getByText('There is no oracle now').waitFor();
    await inspect(navigator, 'dialogue-alone');
    const oracle = await arrive(link, 'oracle');
    await oracle.getByRole('heading', { name: 'You are the oracle' }).waitFor();
    await oracle.getByText('Wait for a question').waitFor();
    await navigator.getByText('It is your turn: walk, or ask.').waitFor();
    const [, second, third] = paths[0]!.path;
    await stepTo(navigator, second!);
    await navigator.getByLabel('Your question').fill('I am in the hall. Left or right?');
    await navigator.keyboard.press('Enter');
    await navigator.getByText('The oracle answers. Wait here.').waitFor();
    expect(await navigator.evaluate(() => window.walkTask!.viewer.steps().length)).toBe(0); // one stays
    await oracle.getByText('I am in the hall. Left or right?').waitFor();
    await oracle.waitForFunction((id) => {
      const { viewer } = window.walkTask!;
      return viewer.scan.viewpoints[viewer.pose.viewpoint]!.id === id;
    }, second!);
    await inspect(oracle, 'dialogue-oracle');
    await oracle.getByLabel('Your answer').fill('Right, through the door, then stop.');
    await oracle.getByRole('button', { name: 'Send' }).click();
    await navigator.getByText('Right, through the door, then stop.').waitFor();
    await navigator.getByText('It is your turn: walk, or ask.').waitFor();
    await inspect(navigator, 'dialogue-navigator');
    await navigator.reload(); // nothing is lost
    await navigator.getByText('Right, through the door, then stop.').waitFor();
    await navigator.waitForFunction(() => window.walkTask !== undefined);
    await stepTo(navigator, third!);
    await oracle.getByText('The navigator is at the goal.').waitFor();
    await oracle.evaluate((heading) => window.walkTask!.viewer.look(heading, 0), east);
    await seesFrame(oracle);
    await keepScreenshot(oracle, 'dialogue-goal');
    await navigator.getByRole('button', { name: 'Stop here: this is the place' }).click();
    await navigator.getByRole('button', { name: 'Yes, I am there' }).click();
    for (const page of [navigator, oracle]) {
      await page.getByRole('heading', { name: /Received|Thank you/ }).waitFor();
      await page.close();
    }
    await organiser.goto(`${home.server}/review?collection=dialogue`);
    await organiser.getByText('1 of 2').waitFor();
    await organiser.getByText('Left or right?').waitFor();
    await inspect(organiser, 'review-dialogue');
    const instances = JSON.parse(await file('dialogue')) as
      { start_pano: { pano: string }; dialog_history: { role: string; nav_idx: number }[]; player_path: string[]; end_panos: string[] }[];
    expect(instances.map(({ dialog_history }) => dialog_history.length)).toEqual([0, 2]);
    expect(instances[1]).toMatchObject({ start_pano: { pano: second }, player_path: [second, third] });
    expect(instances[1]!.end_panos).toContain(third);
    const [whole] = JSON.parse(await file('dialogue', { what: 'dialogues' })) as { turns: { text?: string }[] }[];
    expect(whole!.turns.filter(({ text }) => text !== undefined)).toHaveLength(2);
  });

  it('all kinds made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
