/** Teams at the page Submit: made, logged in, with files to hand in. */
import type { Page } from 'playwright-core';
import { type Home, openPage } from './harness.ts';

/** The page Submit of a new team. @param path with the phase that is chosen at first */
export async function newTeam(home: Home, name: string, path = '/submit'): Promise<Page> {
  const page = await openPage(home, path);
  await page.getByLabel("The team's name").fill(name);
  await page.getByRole('button', { name: 'Create team' }).click();
  await page.locator('.token').waitFor();
  await page.getByRole('button', { name: 'Copy' }).click();
  await page.getByText('Token copied').or(page.getByRole('textbox', { name: 'Token', exact: true })).first().waitFor();
  await page.getByRole('button', { name: 'Log in' }).click();
  await page.getByText('You are').waitFor();
  return page;
}

/** Hands a results file in, to the phase that is chosen on the page. */
export async function handIn(page: Page, method: string, content: string): Promise<void> {
  await page.getByLabel('Method').fill(method);
  await page.getByLabel('Results file').setInputFiles({ name: 'r.json', mimeType: 'application/json', buffer: Buffer.from(content) });
  await page.getByRole('button', { name: 'Check and submit' }).click();
}
