/**
 * The browser of these tests: ENFILADE_BROWSER is chromium (the default) or firefox. CHROMIUM and
 * FIREFOX name other programs than Debian's. Firefox draws only where there is a display: `xvfb-run`.
 */
import { existsSync, mkdirSync, mkdtempSync, readdirSync, renameSync, statSync, writeFileSync } from 'node:fs';
import { rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { type Browser, type BrowserContext, chromium, firefox, type Locator, type Page } from 'playwright-core';

const name = process.env['ENFILADE_BROWSER'] ?? 'chromium';
if (name !== 'chromium' && name !== 'firefox') throw new Error(`ENFILADE_BROWSER is "${name}", neither chromium nor firefox`);
export const isFirefox = name === 'firefox';

const path = isFirefox
  ? process.env['FIREFOX'] ?? '/usr/bin/firefox-esr'
  : process.env['CHROMIUM'] ?? '/usr/bin/chromium';

const why = (): string => {
  const until = Number(process.env['ENFILADE_BROWSERS_UNTIL'] ?? Infinity); // seconds since 1970
  if (Date.now() / 1000 > until) return 'the time of this run for them is over (ENFILADE_BROWSERS_UNTIL)';
  if (!existsSync(path)) return `there is no browser: ${path} (${name.toUpperCase()} names another)`;
  return isFirefox && !process.env['DISPLAY'] ? 'Firefox has no display: run it by xvfb-run' : '';
};
/** Why there is none; empty if there is. */
export const missingBrowser = why();

const downloads = join(tmpdir(), `enfilade-e2e-downloads-${process.pid}`);

/** Chromium draws without a GPU. */
const chromiumArgs = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

// "moz-" makes Playwright speak WebDriver BiDi, which the Firefox of distributions understands.
const launchFirefox = (preferences: Record<string, boolean | number>): Promise<Browser> =>
  firefox.launch({
    executablePath: path, channel: 'moz-firefox', headless: false, downloadsPath: downloads,
    firefoxUserPrefs: {
      'browser.sessionhistory.max_total_viewers': 0, // Playwright loses a page that comes back as it was left
      ...preferences,
    },
  });

export const launchBrowser = (): Promise<Browser> =>
  isFirefox ? launchFirefox({ 'webgl.force-enabled': true }) : chromium.launch({ executablePath: path, args: chromiumArgs });

export const launchWithoutGraphics = (): Promise<Browser> =>
  isFirefox
    ? launchFirefox({ 'webgl.disabled': true })
    : chromium.launch({ executablePath: path, args: [...chromiumArgs, '--disable-3d-apis'] });

/** A browser that lets no frame of another site keep anything: its user's setting. It ends with the context's browser. */
export async function withoutThirdPartyStorage(): Promise<BrowserContext> {
  if (isFirefox) {
    const browser = await launchFirefox({ 'webgl.force-enabled': true, 'network.cookie.cookieBehavior': 1 });
    const context = await browser.newContext();
    context.on('close', () => void browser.close());
    return context;
  }
  const profile = mkdtempSync(join(tmpdir(), 'enfilade-e2e-'));
  mkdirSync(join(profile, 'Default'));
  writeFileSync(join(profile, 'Default/Preferences'), JSON.stringify({ profile: { block_third_party_cookies: true, cookie_controls_mode: 1 } }));
  const context = await chromium.launchPersistentContext(profile, { executablePath: path, args: chromiumArgs });
  // Its helper processes write to it for a while after it has closed. If it cannot be removed, it lies among temporary files.
  context.on('close', () => void rm(profile, { recursive: true, maxRetries: 20, retryDelay: 100 }).catch(() => undefined));
  return context;
}

/** As the browser's button. Playwright's own waits for ever in Firefox by WebDriver BiDi, as of 1.64. */
export const goBack = (page: Page): Promise<void> => page.evaluate(() => history.back());

/** The file that a press on a control saves: where it lies now, under the name that the page gave it. */
export async function download(control: Locator, folder: string): Promise<string> {
  if (!isFirefox) {
    const [file] = await Promise.all([control.page().waitForEvent('download'), control.click()]);
    const saved = join(folder, file.suggestedFilename());
    await file.saveAs(saved);
    return saved;
  }
  // WebDriver BiDi tells of no downloads: Firefox puts them into its folder.
  mkdirSync(downloads, { recursive: true });
  const before = new Set(readdirSync(downloads));
  await control.click();
  for (;;) {
    const names = readdirSync(downloads);
    const name = names.find((one) => !before.has(one) && !one.endsWith('.part'));
    if (name && !names.includes(`${name}.part`) && statSync(join(downloads, name)).size > 0) {
      mkdirSync(folder, { recursive: true });
      renameSync(join(downloads, name), join(folder, name));
      return join(folder, name);
    }
    await new Promise((resolve) => setTimeout(resolve, 50)); // the test's time limit ends it
  }
}
