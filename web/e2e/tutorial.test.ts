/**
 * docs/tutorials/collect.md with its own commands, from an empty folder to the Human row. The organiser uses the pages;
 * workers and the reviewer are scripts at the API, as their pages have tests of their own.
 */
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, symlinkSync } from 'node:fs';
import { delimiter, join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, describe, expect, it } from 'vitest';
import { consentGap } from '../src/collecting/default_texts.ts';
import { download } from './browsers.ts';
import { complaints, type Home, missing, newFolder, openPage, program, serve } from './harness.ts';
import { ask, work } from './work_by_api.ts';

const tutorial = readFileSync(join(import.meta.dirname, '../../docs/tutorials/collect.md'), 'utf8');

/** The commands of a section, without what stands there for people only. */
function commands(section: number): string[] {
  const [, text = ''] = new RegExp(`^## ${section}\\. (.*?)(?=^## |$(?![^]))`, 'ms').exec(tutorial) ?? [];
  return [...text.matchAll(/^```\n(.*?)^```/gms)].flatMap(([, block = '']) => block.trim().split('\n'))
    .map((line) => line.replace(/\s+#.*/, ''));
}

/** Makes a collection on the page. Returns its link. */
async function make(organiser: Page, title: string, kind: string, file: string): Promise<string> {
  const fold = organiser.locator('details.new', { hasText: 'New collection' });
  if (!(await fold.getAttribute('open').then((open) => open !== null))) await organiser.getByText('New collection').click();
  await organiser.getByLabel('Title, for workers').fill(title);
  await organiser.getByLabel('Type of task').selectOption({ label: kind });
  await organiser.getByLabel('A file of paths').setInputFiles(file);
  const consent = organiser.getByRole('textbox', { name: 'Consent', exact: true });
  await consent.fill((await consent.inputValue()).replace(consentGap, 'We are the tests of Enfilade.'));
  await organiser.getByRole('button', { name: 'Create and open' }).click();
  return organiser.getByRole('listitem').filter({ hasText: title }).getByLabel('Link for workers').inputValue();
}

describe.skipIf(missing)('the tutorial', () => {
  let home: Home | undefined;
  afterAll(async () => {
    await home?.stop();
  });

  it('is true from its first command to its last', async () => {
    const folder = newFolder();
    const [programs, downloads] = [join(folder, 'bin'), join(folder, 'Downloads')];
    mkdirSync(programs);
    symlinkSync(program, join(programs, 'enfilade'));
    const environment = { ...process.env, HOME: folder, PATH: programs + delimiter + process.env['PATH'] };
    const run = (command: string): string =>
      execFileSync('bash', ['-c', command], { cwd: folder, env: environment, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });

    const [homes, sample, server, ...rest] = commands(1);
    [homes!, sample!].forEach(run);
    const [, data, database] = /^enfilade serve (\S+) --db (\S+)$/.exec(server!)!;
    expect(rest).toEqual([]);
    home = await serve(folder, join(folder, data!), join(folder, database!));
    const [ada, grace] = commands(2).map((command) => run(command).trim());

    const organiser = await openPage(home, '/organise');
    await organiser.getByLabel('Your token').fill(ada!);
    await organiser.getByRole('button', { name: 'Log in' }).click();
    await organiser.getByText('No collections yet.').waitFor();
    const save = async (title: string, name: string) => {
      await organiser.reload();
      const card = organiser.getByRole('listitem').filter({ hasText: title });
      await card.getByText('Files', { exact: true }).click();
      await download(card.getByRole('link', { name, exact: true }), downloads);
    };

    const link = await make(organiser, 'Write here', 'People write directions', join(folder, 'paths.json'));
    for (const who of ['Bea', 'Cy', 'Dan']) {
      const done = await work(link, ({ path }) => ({ instruction: `Go by ${path!.join(', then ')}, says ${who}.`, seconds: 60, flags: [] }));
      expect(done).toBe(8);
    }
    for (let task = 1; task <= 24; ++task) await ask(`${home.server}/api/v1/tasks/${task}/review`, 'PUT', { verdict: 'accepted' }, grace);
    await save('Write here', 'R2R file');
    expect(commands(6).map(run).at(-1)).toMatch(/^instructions +24 +24$/m);

    const way = await make(organiser, 'Walk here', 'People walk by directions', join(folder, 'mine/r2r/R2R_train.json'));
    const walked = await work(way, ({ instruction }) => ({
      steps: instruction!.match(/[0-9a-f]{32}/g)!.map((viewpoint, seconds) => ({ viewpoint, heading: 0, elevation: 0, seconds })),
      camera: { width: 640, height: 480, vfov: 1 },
    }));
    expect(walked).toBe(24);
    for (const name of ['results', 'R2R file', 'walks with times']) await save('Walk here', name);
    expect(commands(7).map(run).at(-1)).toMatch(/^SR \(%\) +100\.0/m);
    commands(8).forEach(run);
    expect(existsSync(join(folder, 'study-friday.sqlite'))).toBe(true);
    expect(complaints).toEqual([]);
  });
});
