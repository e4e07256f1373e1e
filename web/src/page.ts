/** What all pages have: making elements, the header, telling what went wrong. */
import { Api, ServerError } from './scan.ts';

export const api = new Api();

/** How to send a body. */
export const json = (body: unknown, method = 'POST') => ({
  method, body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' },
});

type Child = Node | string;

/** An element. Texts become text nodes: what people wrote is never read as markup. */
export function make<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Record<string, string> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** What is said already isn't said again: screen readers would repeat it. */
export function say(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

/** Address and name of a page. */
export type Link = readonly [string, string];

const siteLinks: readonly Link[] = [
  ['/', 'Buildings'],
  ['/episodes', 'Episodes'],
  ['/leaderboard', 'Leaderboard'],
  ['/submit', 'Submit'],
  ['/organise', 'Collections'],
];

/** The header, before the page's main part. Workers get no links: one page is all they came for. */
export function addHeader(synthetic: boolean, links: readonly Link[] = siteLinks): void {
  const header = make('header', { class: 'site' },
    links.length > 0 ? make('a', { href: '/', class: 'name' }, 'Enfilade') : make('span', { class: 'name' }, 'Enfilade'));
  const nav = make('nav', { 'aria-label': 'Pages', class: 'site-links' });
  for (const [href, text] of links) {
    const here = location.pathname === href;
    nav.append(make('a', { href, ...(here && { 'aria-current': 'page' }) }, text), ' ');
  }
  if (links.length > 0) header.append(nav);
  if (synthetic) {
    const title = 'The buildings here are made by a program; they are not real ones';
    header.append(make('span', { class: 'synthetic', title }, 'Model homes: synthetic'));
  }
  document.body.prepend(make('a', { href: '#main', class: 'skip' }, 'To the content'), header);
}

/** The header of a page that shows no building by itself. */
export async function addSiteHeader(): Promise<void> {
  const { synthetic } = await api.call<{ synthetic: boolean }>('scans');
  addHeader(synthetic);
}

/** A table that can be wider than the screen. A heading stands over its column's numbers as they do: to the right. */
export function table(head: readonly Child[], rows: readonly (readonly Child[])[]): HTMLElement {
  const isCell = (child: Child | undefined) => child instanceof HTMLTableCellElement;
  const cell = (child: Child) => (isCell(child) ? child : make('td', {}, child));
  const heading = (child: Child, k: number) => {
    const first = rows[0]?.[k];
    const number = first instanceof HTMLElement && first.classList.contains('number');
    return isCell(child) ? child : make('th', { scope: 'col', ...(number && { class: 'number' }) }, child);
  };
  return make(
    'div',
    { class: 'table', tabindex: '0', role: 'region', 'aria-label': 'Table' },
    make(
      'table',
      {},
      make('thead', {}, make('tr', {}, ...head.map(heading))),
      make('tbody', {}, ...rows.map((row) => make('tr', {}, ...row.map(cell)))),
    ),
  );
}

/** A message, with the problems of a file in a list. */
export function problems(error: unknown): HTMLElement {
  // The server's sentences begin small, as a program's do; a field's name stays as it is.
  const message = (error instanceof Error ? error.message : String(error)).replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase());
  const box = make('div', { role: 'alert' }, make('p', { class: 'problem' }, message));
  if (error instanceof ServerError && error.problems.length > 0) {
    box.append(
      table(
        ['Where', 'What', 'Code'],
        error.problems.map(({ where, message: text, code }) => [where, text, code]),
      ),
    );
  }
  return box;
}

/**
 * Runs a page; what goes wrong is shown on it.
 * @param failure the heading then, where there is none yet
 */
export function run(page: () => Promise<void>, failure = 'This page cannot be shown', links = siteLinks): void {
  page().catch((error: unknown) => {
    const main = byId('main');
    if (main.classList.contains('wide')) main.replaceChildren(); // an empty view
    main.classList.remove('wide');
    if (!document.querySelector('header')) addHeader(false, links);
    if (!main.querySelector('h1')) main.append(make('h1', {}, failure));
    main.append(problems(error));
  });
}

/** "2026-11-21 19:40", as the server says it (UTC). */
export const dateTime = (iso: string): string => iso.slice(0, 16).replace('T', ' ');
