/** Where workers are: in frames that may keep nothing, with a server that goes away, in two tabs, without graphics. */
import type { FrameLocator, Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { isFirefox, launchWithoutGraphics, withoutThirdPartyStorage } from './browsers.ts';
import { complaints, type Home, inspect, keepScreenshot, makeCollection, missing, newToken, openHome, openPage, patience, watch } from './harness.ts';
import { frameOf, openTurk, type StandIn, storageOf } from './stand_ins.ts';

const texts = { consent: '# Consent\n\nDo you agree?', instructions: '# Write\n\nLook around.' };
const directions = 'Leave the room, turn left, go past the sofa and stop at the door.';

describe.skipIf(missing)('workers', () => {
  let home: Home;
  let organiser: Page;
  let turk: StandIn;
  beforeAll(async () => {
    home = await openHome();
    turk = await openTurk();
    organiser = await openPage(home, '/organise');
    await organiser.getByLabel('Your token').fill(newToken(home, 'Ada', 'organiser'));
    await organiser.getByRole('button', { name: 'Log in' }).click();
    await organiser.getByText('No collections yet.').waitFor();
  });
  afterAll(async () => {
    await turk?.stop();
    await home?.stop();
  });

  const ids = () => new URLSearchParams({ assignmentId: 'A1', hitId: 'H1', workerId: 'W1', turkSubmitTo: turk.origin });
  const turkCollection = (name: string, kind: 'write' | 'walk') => makeCollection(organiser, {
    ...texts, name, title: 'Directions', kind, sources: [{ split: 'val_seen', most: 1 }], pay: '$1.20 a path', minutes: 4,
    platform: { kind: 'mturk', origins: [turk.origin] },
  });
  /** A click on a button. Those of WebDriver BiDi do not reach a frame of another site: there it gets the event alone. */
  const press = async (page: Page | FrameLocator, name: string) => {
    const button = page.getByRole('button', { name });
    if (isFirefox && !('goto' in page)) await button.dispatchEvent('click');
    else await button.click();
  };
  const submitTwice = async (page: Page | FrameLocator, advice = true) => {
    await press(page, 'Submit');
    if (!advice) return;
    await page.getByText('If it is right as it is').waitFor(); // the goal wasn't looked at
    await press(page, 'Submit');
  };

  it('write and walk in the frame of Mechanical Turk, which keeps nothing', async () => {
    const context = await withoutThirdPartyStorage();
    context.setDefaultTimeout(patience);
    const write = await turkCollection('turk-write', 'write');
    const preview = await context.newPage();
    await preview.goto(turk.page(`${home.server}${write}&assignmentId=ASSIGNMENT_ID_NOT_AVAILABLE&hitId=H1`));
    const shown = preview.frameLocator('iframe');
    await shown.getByText('This is a preview').waitFor();
    await shown.getByText('$1.20 a path').waitFor();
    expect(await shown.getByRole('button', { name: 'Submit' }).isDisabled()).toBe(true);
    await keepScreenshot(preview, 'turk-preview');
    await preview.close();

    const page = await context.newPage();
    const failures: string[] = [];
    page.on('pageerror', (error) => failures.push(String(error)));
    await page.goto(turk.page(`${home.server}${write}&${ids()}`));
    // It is blocked indeed: without this, the test would show nothing.
    expect(await storageOf(await frameOf(page)))
      .toEqual({ local: 'SecurityError', session: isFirefox ? 'kept' : 'SecurityError', cookie: 'nothing' });
    const frame = page.frameLocator('iframe');
    await frame.getByText('About 4 minutes each').waitFor();
    await press(frame, 'I agree');
    await press(frame, 'Start');
    await frame.getByLabel('Your directions').fill(directions);
    await frame.getByText('Draft saved.').waitFor();
    await keepScreenshot(page, 'turk-task');
    await page.reload(); // the assignment says who it is, and the server has the text
    await expect.poll(() => frame.getByLabel('Your directions').inputValue(), { timeout: patience }).toBe(directions);
    await submitTwice(frame);
    await press(frame, 'Submit to Mechanical Turk');
    await frame.getByText('Taken by the stand-in').waitFor();
    expect(turk.forms.map((form) => form.get('assignmentId'))).toEqual(['A1']);

    const walk = await turkCollection('turk-walk', 'walk');
    await page.goto(turk.page(`${home.server}${walk}&${ids()}`));
    await press(frame, 'I agree');
    await press(frame, 'Start');
    await press(frame, 'Stop here');
    await press(frame, 'Yes, this is the goal');
    await press(frame, 'Submit to Mechanical Turk');
    await frame.getByText('Taken by the stand-in').waitFor();
    expect(turk.forms).toHaveLength(2);
    expect(failures).toEqual([]);
    await context.close();
  });

  it('come from Prolific and go back with its code; who is screened out gets another', async () => {
    const link = await makeCollection(organiser, {
      ...texts, name: 'prolific', title: 'Directions', kind: 'write', sources: [{ split: 'val_seen', most: 1 }],
      platform: { kind: 'prolific', completion_code: 'C0DE42', screen_out_code: '0UT7' },
      screening: [{ question: 'Do you see well?', choices: ['Yes', 'No'], accept: ['Yes'] }],
    });
    // What Prolific does with a study's address: it fills in the placeholders, in a tab of its own.
    const filled = (who: string) => link.replace('{{%PROLIFIC_PID%}}', who).replace('{{%STUDY_ID%}}', 's1').replace('{{%SESSION_ID%}}', `x-${who}`);
    const returned = async (who: string, answer: string): Promise<string> => {
      const page = await openPage(home, filled(who));
      let back = '';
      await page.route('https://app.prolific.com/**', (route) => {
        back = route.request().url();
        return route.fulfill({ contentType: 'text/html', body: '<p>Taken by the stand-in</p>' });
      });
      await page.getByRole('button', { name: 'I agree' }).click();
      await page.getByRole('radio', { name: answer }).check();
      if (answer === 'Yes') await inspect(page, 'collect-screening');
      await page.getByRole('button', { name: 'Next' }).click();
      if (answer === 'Yes') {
        await page.getByRole('button', { name: 'Start' }).click();
        await page.getByLabel('Your directions').fill(directions);
        await submitTwice(page);
        await page.getByText('C0DE42').waitFor();
        await inspect(page, 'collect-prolific');
      } else {
        await page.getByText('this study is not for you').waitFor();
        await inspect(page, 'collect-screened-out');
      }
      await page.getByRole('link', { name: 'Back to Prolific' }).click();
      await page.getByText('Taken by the stand-in').waitFor();
      await page.close();
      return back;
    };
    expect(await returned('p1', 'Yes')).toBe('https://app.prolific.com/submissions/complete?cc=C0DE42');
    expect(await returned('p2', 'No')).toBe('https://app.prolific.com/submissions/complete?cc=0UT7');
  });

  it('are told before the consent that a browser without graphics cannot show it', async () => {
    const link = await turkCollection('no-graphics', 'write');
    const browser = await launchWithoutGraphics();
    const page = await browser.newPage();
    page.setDefaultTimeout(patience);
    await page.goto(`${home.server}${link}&${ids()}`);
    expect(await page.evaluate(() => document.createElement('canvas').getContext('webgl2'))).toBeNull();
    await page.getByRole('heading', { name: 'This browser cannot show the buildings' }).waitFor();
    await page.getByText('return the HIT').waitFor();
    await inspect(page, 'collect-no-graphics');
    expect(await page.getByRole('button').count()).toBe(0);
    await browser.close();
    const { visits } = await organiser.evaluate(async () => (await fetch('/api/v1/collections/no-graphics/workers')).json()) as { visits: unknown[] };
    expect(visits).toEqual([]); // no visit was recorded
  });

  it('have a day: questions, practice, a crash, a second tab, a rejection', async () => {
    const link = await makeCollection(organiser, {
      ...texts, name: 'day', title: 'A day', kind: 'write', per_item: 1, pay: '$1.20 a path', minutes: 4,
      sources: [{ split: 'val_seen', most: 1, practice: true }, { split: 'val_seen', most: 4 }],
      screening: [{ question: 'Do you see well?', choices: ['Yes', 'No'], accept: ['Yes'] }],
      checks: [{ question: 'Choose the blue one.', choices: ['Red', 'Blue'], accept: ['Blue'] }], check_every: 2,
    });
    const context = await home.browser.newContext({ viewport: { width: 1280, height: 800 } });
    const open = async (): Promise<Page> => {
      const tab = await context.newPage();
      watch(tab);
      await tab.goto(home.server + link);
      return tab;
    };
    const page = await open();
    for (const fact of ['$1.20 a path', '3 paths to describe, after 1 practice task', 'About 4 minutes each, 12 minutes in all']) {
      await page.getByText(fact).waitFor();
    }
    await inspect(page, 'collect-conditions');
    await page.getByRole('button', { name: 'I agree' }).click();
    await page.getByRole('radio', { name: 'Yes' }).check();
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByRole('button', { name: 'Start with practice' }).click();
    await page.getByText('this one does not count').waitFor();
    await page.getByLabel('Your directions').fill(directions);
    await submitTwice(page);
    await page.getByText('Another person wrote for the same path').waitFor();
    await inspect(page, 'collect-practised');
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByText('Task 1 of 3').waitFor();

    // Too short: said beside the text, in sight, in words.
    const text = page.getByLabel('Your directions');
    await text.fill('Go left');
    await page.getByRole('button', { name: 'Submit' }).click();
    const refusal = page.getByText('This is too short to lead anybody');
    await refusal.waitFor();
    const [box, said] = [(await text.boundingBox())!, (await refusal.boundingBox())!];
    expect(said.y - (box.y + box.height)).toBeLessThan(20);
    expect(said.y + said.height).toBeLessThan(page.viewportSize()!.height);
    expect(await page.getByRole('table').count()).toBe(0);
    await expect.poll(() => text.evaluate((element) => element === document.activeElement)).toBe(true);

    // The server dies while one writes, and while one submits.
    await home.crash();
    await text.fill(directions);
    await page.getByText('We saved your text here').waitFor();
    const silence = page.getByText('The server does not answer. Trying again…');
    await silence.waitFor();
    await inspect(page, 'collect-server-gone');
    await submitTwice(page);
    await page.waitForTimeout(6000); // and again
    await home.revive();
    await page.getByText('You have submitted 1 of 3.').waitFor();
    await silence.waitFor({ state: 'detached' });

    // An attention check, and the second task in a second tab.
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByText('Choose the blue one.').waitFor();
    await inspect(page, 'collect-check');
    await page.getByRole('radio', { name: 'Red' }).check();
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByText('Task 2 of 3').waitFor();
    await text.fill(`${directions} In tab one.`);
    const second = await open();
    await page.getByRole('heading', { name: 'You opened this in another tab' }).waitFor();
    await second.getByText('Your other tab with this page has stopped').waitFor();
    await expect.poll(() => second.getByLabel('Your directions').inputValue(), { timeout: patience }).toBe(`${directions} In tab one.`);
    await inspect(page, 'collect-other-tab');
    await page.close();
    await submitTwice(second);
    await second.getByText('You have submitted 2 of 3.').waitFor();

    // One is rejected, by keys, and its worker reads why.
    await organiser.goto(`${home.server}/review?collection=day`);
    await organiser.getByText('1 of 2').waitFor();
    await organiser.keyboard.press('r');
    await organiser.keyboard.type('It leads to another room.');
    await organiser.keyboard.press('Enter');
    await organiser.getByText('2 of 2').waitFor();
    await organiser.keyboard.press('a');
    await organiser.getByRole('heading', { name: 'All reviewed' }).waitFor();
    await second.reload();
    await second.getByText('It leads to another room.').waitFor();
    await inspect(second, 'collect-rejected');
    await second.getByRole('button', { name: 'Next' }).click();
    await second.getByText(/^Task 3 of 3/).waitFor();
    await second.getByLabel('Your directions').fill(directions);
    await submitTwice(second);
    await second.getByRole('heading', { name: 'Thank you' }).waitFor(); // no press more: nothing is left
    await second.getByText('Your 3 tasks have been received.').waitFor();
    await inspect(second, 'collect-day-done');
    await context.close();

    // The organiser sees all of that, and what the file leaves out.
    const { workers } = await organiser.evaluate(async () => (await fetch('/api/v1/collections/day/work/workers')).json()) as
      { workers: { checks: number; checks_failed: number; rejected: number }[] };
    expect(workers).toMatchObject([{ checks: 1, checks_failed: 1, rejected: 1 }]);
    await organiser.goto(`${home.server}/organise`);
    const card = organiser.getByRole('listitem').filter({ hasText: 'A day' });
    await card.getByText('Files', { exact: true }).click();
    await card.getByText('1 of 3 paths have directions; 2 texts are left out: 1 not reviewed yet, 1 rejected.').waitFor();
    await organiser.goto(`${home.server}/review?collection=day&view=agreement`);
    await organiser.getByRole('cell', { name: 'Choose the blue one.' }).waitFor();
    await organiser.getByRole('cell', { name: 'Red: 1 · ✓ Blue: 0' }).waitFor(); // a question with a known answer
    await inspect(organiser, 'review-checks');
    await organiser.goto(`${home.server}/organise`);
    await organiser.getByRole('searchbox').fill('a day');
    await expect.poll(() => organiser.locator('.card').count(), { timeout: patience }).toBe(1);
    await inspect(organiser, 'organise-found');
  });

  it('made no browser complain', () => {
    expect(complaints).toEqual([]);
  });
});
