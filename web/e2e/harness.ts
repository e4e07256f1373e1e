/**
 * The real server, with a data set of model homes that the program makes, and a browser. Needs
 * ENFILADE_PROGRAM, an `enfilade` that was built with EN_WITH_WEB.
 */
import { type ChildProcess, execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser, Page } from 'playwright-core';
import { afterAll, beforeAll, expect } from 'vitest';
import { isFirefox, launchBrowser, missingBrowser } from './browsers.ts';

export const program = process.env['ENFILADE_PROGRAM'] ?? '';

/** Why these tests can't run here; empty if they can. */
export const missing = existsSync(program) ? missingBrowser : 'ENFILADE_PROGRAM names no program';
if (missing) console.warn(`browser tests are skipped: ${missing}`);

export interface Home {
  /** The data set. */
  readonly folder: string;
  readonly database: string;
  readonly server: string;
  readonly browser: Browser;
  /** Kills the server, as a crash does. */
  crash(): Promise<void>;
  /** Starts it again, at the same address. */
  revive(): Promise<void>;
  stop(): Promise<void>;
}

/** Runs `enfilade`, and has what it prints. Throws if it fails. */
export const enfilade = (...args: readonly string[]): string => execFileSync(program, args, { encoding: 'utf8' });

/** A new token, as the organiser makes it on the server's machine. */
export const newToken = (home: Home, label: string, role: 'organiser' | 'reviewer'): string =>
  enfilade('serve', 'token', '--db', home.database, '--label', label, '--role', role).trim();

/** Model homes: synthetic, and the same in every run. */
export function makeHomes(data: string, more: readonly string[] = []): void {
  execFileSync(program, ['homes', '-o', data, '--homes', '1', '--kind', 'flat', '--area', '60',
    '--size', '256', '--samples', '1', '--paths', '0', ...more], { stdio: 'ignore' });
}

interface Entry { readonly image_id: string; readonly unobstructed: readonly boolean[] }

export const scan = 'home0001';

/** Six paths of three viewpoints of the home: their ids. */
export function pathsOf(data: string): string[][] {
  const graph = JSON.parse(
    readFileSync(join(data, `connectivity/${scan}_connectivity.json`), 'utf8'),
  ) as Entry[];
  const next = (k: number) => graph[k]!.unobstructed.flatMap((open, to) => (open ? [to] : []));
  const paths: number[][] = [];
  graph.forEach((_, a) => {
    const b = next(a)[0];
    const c = b === undefined ? undefined : next(b).find((k) => k !== a);
    if (b !== undefined && c !== undefined && paths.length < 6) paths.push([a, b, c]);
  });
  return paths.map((path) => path.map((v) => graph[v]!.image_id));
}

/** The paths as val_seen, with an instruction that tries to be a script. */
export function writeAnnotations(data: string): void {
  const annotations = pathsOf(data).map((path, k) => ({
    path_id: k + 1,
    scan,
    heading: 0.5,
    path,
    distance: 4,
    instructions: ['Walk on.', '<img src=x onerror=alert(1)> Turn left.', 'Go to the end.'],
  }));
  mkdirSync(join(data, 'r2r'), { recursive: true });
  writeFileSync(join(data, 'r2r/R2R_val_seen.json'), JSON.stringify(annotations));
}

/** Beside val_seen a split test of one episode, 9_0, whose goal is hidden. */
export function writeHiddenSplit(data: string): void {
  const [path] = pathsOf(data);
  const episode = { path_id: 9, scan, heading: 0.5, path: path!.slice(0, 1), instructions: ['Go on.'] };
  writeFileSync(join(data, 'r2r/R2R_test.json'), JSON.stringify([episode]));
}

async function listen(child: ChildProcess): Promise<string> {
  for await (const chunk of child.stdout!) {
    const found = /http:\/\/[\d.]+:\d+/.exec(String(chunk));
    if (found) return found[0];
  }
  throw new Error('the server ended before it listened');
}

export const newFolder = (): string => mkdtempSync(join(tmpdir(), 'enfilade-e2e-'));

/** In a new folder: the model home with val_seen. */
export function newData(): { readonly folder: string; readonly data: string } {
  const folder = newFolder();
  const data = join(folder, 'homes');
  makeHomes(data);
  writeAnnotations(data);
  return { folder, data };
}

export async function openHome(): Promise<Home> {
  const { folder, data } = newData();
  enfilade('ask', '--data', data, '--split', 'val_seen', '--stand-in', 'oracle', '-o', join(folder, 'runs/oracle'));
  return serve(folder, data, join(folder, 'service.sqlite'), ['--runs', join(folder, 'runs')]);
}

/** With a mesh and a floor for /roam, and without runs. */
export async function openRoamHome(): Promise<Home> {
  const { folder, data } = newData();
  enfilade('continuous', data);
  return serve(folder, data, join(folder, 'service.sqlite'));
}

/** Opens a home before the tests of a block, and stops it after them. */
export function withHome(use: (home: Home) => void): void {
  let home: Home | undefined;
  beforeAll(async () => {
    home = await openHome();
    use(home);
  });
  afterAll(() => home?.stop());
}

/** Serves a data set, and opens a browser. The folder goes when it stops. */
export async function serve(folder: string, data: string, database: string, more: readonly string[] = []): Promise<Home> {
  const start = (port: string) => spawn(program, ['serve', data, '--db', database, '--port', port,
    '--log', 'none', '--open-registration', ...more], { stdio: ['ignore', 'pipe', 'inherit'] });
  const end = async (signal: NodeJS.Signals) => {
    const ended = new Promise((resolve) => child.once('exit', resolve));
    child.kill(signal);
    await ended;
  };
  let child = start('0');
  const server = await listen(child);
  if (!(await fetch(server)).ok) {
    child.kill();
    throw new Error(`${program} has no pages in it: it was built where npm was not found`);
  }
  const browser = await launchBrowser();
  return {
    folder: data, database, server, browser,
    crash: () => end('SIGKILL'),
    revive: async () => {
      child = start(new URL(server).port);
      await listen(child);
    },
    stop: async () => {
      await browser.close();
      await end('SIGTERM');
      rmSync(folder, { recursive: true });
    },
  };
}

/** A results file for val_seen: each walk stays at its start, or goes to its goal. */
export async function results(home: Home, walk: boolean): Promise<string> {
  const answer = await fetch(`${home.server}/api/v1/splits/val_seen/episodes?limit=500`);
  const { episodes } = (await answer.json()) as {
    episodes: { instruction_id: string; path: string[]; heading: number }[];
  };
  return JSON.stringify(episodes.map(({ instruction_id, path, heading }) => ({
    instr_id: instruction_id,
    trajectory: (walk ? path : path.slice(0, 1)).map((id) => [id, heading, 0]),
  })));
}

/** A collection by the API, as the page of a logged-in organiser makes it. Returns its link. */
export const makeCollection = (organiser: Page, body: object): Promise<string> =>
  organiser.evaluate(async (wanted) => {
    const answer = await fetch('/api/v1/collections', {
      method: 'POST', body: JSON.stringify(wanted), headers: { 'X-Enfilade': '1', 'Content-Type': 'application/json' },
    });
    const made = (await answer.json()) as { link?: string; error?: object };
    if (!made.link) throw new Error(JSON.stringify(made.error));
    return made.link;
  }, body);

/** For anything to happen in a browser, milliseconds: tests share their machine with builds. */
export const patience = 120_000;

/** A page that fails its test when a script fails or the content policy is hurt. */
export async function openPage(home: Home, path: string, phone = false): Promise<Page> {
  const page = await home.browser.newPage({
    viewport: phone ? { width: 390, height: 844 } : { width: 1440, height: 900 },
    hasTouch: phone,
  });
  watch(page);
  await page.goto(home.server + path);
  return page;
}

/** Hears what the page's browser complains of. */
export function watch(page: Page): void {
  page.setDefaultTimeout(patience);
  const complain = (text: string) => {
    // Before a screenshot in Firefox Playwright adds the style "body {}", of this hash, which the pages' policy forbids.
    if (!text.includes('sha256-YjaKGiklmzC6wjXA513HAMmzus8VE61XCOT+SmwNZWA=')) complaints.push(text);
  };
  page.on('pageerror', (error) => { complain(String(error)); });
  page.on('console', (message) => {
    // What a page asks for and doesn't get is the page's to show.
    const expected = message.text().startsWith('Failed to load resource');
    if (message.type() === 'error' && !expected) complain(message.text());
  });
}

/** What browsers complained of since the start. */
export const complaints: string[] = [];

interface Violation { readonly id: string; readonly impact: string; readonly nodes: { html: string }[] }
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** What axe-core finds that keeps people out. */
export async function seriousFaults(page: Page): Promise<string[]> {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() =>
    (globalThis as unknown as { axe: { run(): Promise<{ violations: Violation[] }> } }).axe.run());
  return violations
    .filter(({ impact }) => impact === 'serious' || impact === 'critical')
    .map(({ id, nodes }) => `${id}: ${nodes[0]?.html}`);
}

/**
 * A page as it stands: nothing in it keeps people out, and nothing is wider than the screen, on a
 * desktop and on a phone, with light and with dark colours. Keeps a picture of each.
 */
export async function inspect(page: Page, name: string): Promise<void> {
  const before = page.viewportSize()!;
  for (const [kind, width, height, colorScheme] of [
    ['desktop', 1440, 900, 'light'], ['desktop-dark', 1440, 900, 'dark'], ['phone', 390, 844, 'light'], ['phone-dark', 390, 844, 'dark']] as const) {
    await page.setViewportSize({ width, height });
    await page.emulateMedia({ colorScheme });
    await page.waitForTimeout(200); // until the view has its new size
    await page.evaluate(() => Promise.all(document.getAnimations() // those that end: colours are faint meanwhile
      .filter(({ effect }) => Number.isFinite(effect?.getComputedTiming().endTime)).map(({ finished }) => finished)));
    expect(await seriousFaults(page), `${name}, ${kind}`).toEqual([]);
    const wider = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    expect(wider, `${name}, ${kind}: pixels too wide`).toBeLessThanOrEqual(0);
    await keepScreenshot(page, `${name}-${kind}`, kind.startsWith('phone'));
  }
  await page.emulateMedia({ colorScheme: 'light' });
  await page.setViewportSize(before);
}

/** Nothing moved by itself on a page so far. Browsers count how much did: 0.1 is the limit of "good". Chromium alone tells. */
export async function expectStill(page: Page): Promise<void> {
  if (isFirefox) return;
  const { sum, moved } = await page.evaluate(() => new Promise<{ sum: number; moved: string[] }>((resolve) => {
    let sum = 0;
    const moved: string[] = [];
    type Shift = PerformanceEntry & {
      readonly value: number; readonly hadRecentInput: boolean; readonly sources: readonly { readonly node?: Node }[];
    };
    new PerformanceObserver((list) => {
      for (const { value, hadRecentInput, sources } of list.getEntries() as Shift[]) {
        if (hadRecentInput) continue;
        sum += value;
        const parts = sources.map(({ node }) => (node instanceof Element ? node.outerHTML : String(node?.textContent)).slice(0, 80));
        moved.push(`${value.toFixed(3)}: ${parts.join(' | ')}`);
      }
    }).observe({ type: 'layout-shift', buffered: true });
    setTimeout(() => resolve({ sum, moved }), 300);
  }));
  expect(sum, `at ${page.viewportSize()!.width} pixels: ${moved.join('\n')}`).toBeLessThanOrEqual(0.02);
}

/** Into the folder ENFILADE_SCREENSHOTS, or of Firefox into firefox/ in it, for a person to look at. */
export async function keepScreenshot(page: Page, name: string, fullPage = false): Promise<void> {
  const folder = process.env['ENFILADE_SCREENSHOTS'];
  if (folder) await page.screenshot({ path: join(folder, isFirefox ? 'firefox' : '', `${name}.png`), fullPage });
}
