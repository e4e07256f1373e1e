/** Pages with no mouse: what Tab comes to, its names, and whether it shows the focus. */
import type { Page } from 'playwright-core';
import { expect } from 'vitest';
import { isFirefox } from './browsers.ts';

export interface Stop {
  readonly name: string;
  readonly tag: string;
  readonly outlined: boolean;
}

/** Runs in the page: what has the focus; nothing if that is the page itself. */
export function focused(): Stop | undefined {
  const element = document.activeElement as (HTMLElement & { labels?: NodeListOf<HTMLElement> }) | null;
  if (!element || element === document.body || element === document.documentElement) return undefined;
  const label = element.labels?.[0]?.textContent;
  const name = element.getAttribute('aria-label') ?? label ?? element.textContent ?? '';
  const { outlineStyle, outlineWidth } = getComputedStyle(element);
  return { name: name.trim(), tag: element.tagName, outlined: outlineStyle !== 'none' && Number.parseFloat(outlineWidth) >= 2 };
}

/** All that Tab comes to, in its order. */
async function stops(page: Page): Promise<Stop[]> {
  const found: Stop[] = [];
  for (let k = 0; k < 150; ++k) {
    await page.keyboard.press('Tab');
    const stop = await page.evaluate(focused);
    if (!stop) return found;
    found.push(stop);
  }
  throw new Error(`the focus does not leave the page: ${found.slice(-3).map(({ name }) => name).join(', ')}`);
}

/** Presses Tab until something of that name has the focus. */
export async function tabTo(page: Page, name: RegExp, key: 'Tab' | 'Shift+Tab' = 'Tab'): Promise<void> {
  const passed: string[] = [];
  for (let k = 0; k < 150; ++k) {
    await page.keyboard.press(key);
    const stop = await page.evaluate(focused);
    if (stop && name.test(stop.name)) return;
    passed.push(stop?.name ?? '(page)');
  }
  throw new Error(`Tab does not come to ${name}: ${[...new Set(passed)].join(', ')}`);
}

/**
 * Each control can be reached, has a name, and shows that it has the focus.
 * @param last whether this is the last that the test does there. After the last control Firefox gives the focus to its own, and WebDriver
 * BiDi cannot take it back.
 */
export async function expectReached(page: Page, last = false): Promise<void> {
  if (isFirefox && !last) return;
  const found = await stops(page);
  expect(found.length).toBeGreaterThan(0);
  for (const stop of found) {
    expect(stop.name, `the name of a ${stop.tag}`).not.toBe('');
    expect(stop.outlined, `the focus on ${stop.name}`).toBe(true);
  }
  const controls = await page.locator('main').evaluate((main) =>
    [...main.querySelectorAll<HTMLElement>('button, input, select, textarea, a[href], summary')]
      .filter((one) => one.checkVisibility() && !one.matches(':disabled')).length);
  expect(found.length).toBeGreaterThanOrEqual(controls);
}
