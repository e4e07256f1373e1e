/** What all pages have: making elements, the header, telling what went wrong. */
import { api, ServerError } from '../server/api.ts';

type Child = Node | string;

/** "1 room", "2,300 rooms". @param one without the s */
export const counted = (n: number, one: string): string => `${n.toLocaleString('en-US')} ${one}${n === 1 ? '' : 's'}`;

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

const syntheticBadge = (): HTMLElement => make('span',
  { class: 'badge synthetic', title: 'The buildings here are made by a program; they are not real ones' }, 'Model homes: SYNTHETIC');

/** What the header says of a server, as answers about its scans have it. */
export interface Served {
  readonly synthetic: boolean;
  /** Whether there are runs to look at: /replay. */
  readonly runs?: boolean;
}

const runsLink: Link = ['/replay', 'Runs'];

const linkTo = ([href, text]: Link): HTMLElement =>
  make('a', { href, ...(location.pathname === href && { 'aria-current': 'page' }) }, text);

/** The header, before the page's main part. Workers get no links: one page is all they came for. */
export function addHeader({ synthetic, runs = false }: Served, links: readonly Link[] = runs ? [...siteLinks, runsLink] : siteLinks): HTMLElement {
  const header = make('header', { class: 'site' },
    links.length > 0 ? make('a', { href: '/', class: 'name' }, 'Enfilade') : make('span', { class: 'name' }, 'Enfilade'));
  const nav = make('nav', { 'aria-label': 'Pages', class: 'site-links' });
  nav.append(...links.map(linkTo));
  if (links.length > 0) header.append(nav);
  if (synthetic) header.append(syntheticBadge());
  document.body.prepend(make('a', { href: '#main', class: 'skip' }, 'Skip to the content'), header);
  return header;
}

/** The header of a page that shows no building by itself. It is there at once; the server then says whether the data is synthetic. */
export async function addSiteHeader(): Promise<void> {
  const header = addHeader({ synthetic: false });
  const { synthetic, runs } = await api.call<Served>('scans');
  if (runs) header.querySelector('nav')!.append(linkTo(runsLink));
  if (synthetic) header.append(syntheticBadge());
}

/** Where a page is: the pages above it, and its own name. */
export const crumbs = (above: readonly Link[], here: string): HTMLElement =>
  make('nav', { class: 'crumbs', 'aria-label': 'Breadcrumbs' }, make('ol', {},
    ...above.map(([href, text]) => make('li', {}, make('a', { href }, text))),
    make('li', { 'aria-current': 'page' }, here)));

/** A few numbers in a row. */
export const facts = (list: readonly (readonly [string, Child])[]): HTMLElement =>
  make('dl', { class: 'facts' }, ...list.map(([name, value]) => make('div', {}, make('dt', {}, name), make('dd', {}, value))));

/** What stands where there is nothing yet, or nothing was found. */
export const empty = (title: string, text: string, ...actions: HTMLElement[]): HTMLElement =>
  make('div', { class: 'empty' }, make('h2', {}, title), make('p', {}, text),
    ...(actions.length > 0 ? [make('p', { class: 'buttons' }, ...actions)] : []));

/** What stands where something is being fetched. */
export const loading = (): HTMLElement => make('p', { class: 'loading', role: 'status' }, 'Loading…');

/** Something said in passing. It goes by itself, so nothing may depend on its being read. */
export function toast(text: string): void {
  let box = document.querySelector<HTMLElement>('.toasts');
  if (!box) {
    box = make('div', { class: 'toasts', role: 'status' });
    document.body.append(box);
  }
  const one = make('div', { class: 'toast' }, text);
  box.append(one);
  setTimeout(() => one.remove(), 5000);
}

/** scroll: a table wider than the screen moves under its edges; stack: on a phone each row is a card (style.css). */
type TableKind = 'scroll' | 'stack';

/** A table that can be wider than the screen. A heading stands over its column's numbers as they do: to the right. */
export function table(
  head: readonly Child[], rows: readonly (readonly Child[])[], { kind = 'scroll', label = 'Table' }: { kind?: TableKind; label?: string } = {},
): HTMLElement {
  // Browsers take elements that CSS lays out as a grid for no table any more, if nothing else says that they are one.
  const role = (name: string): Record<string, string> => (kind === 'stack' ? { role: name } : {});
  const isCell = (child: Child | undefined) => child instanceof HTMLTableCellElement;
  const cell = (child: Child) => {
    const made = isCell(child) ? (child as HTMLTableCellElement) : make('td', {}, child);
    if (kind === 'stack') made.setAttribute('role', 'cell');
    return made;
  };
  const heading = (child: Child, k: number) => {
    const first = rows[0]?.[k];
    const number = first instanceof HTMLElement && first.classList.contains('number');
    const made = isCell(child) ? (child as HTMLTableCellElement) : make('th', { scope: 'col', ...(number && { class: 'number' }) }, child);
    if (kind === 'stack') made.setAttribute('role', 'columnheader');
    return made;
  };
  return make(
    'div',
    { class: kind === 'stack' ? 'table stack' : 'table', tabindex: '0', role: 'region', 'aria-label': label },
    make(
      'table',
      role('table'),
      make('thead', role('rowgroup'), make('tr', role('row'), ...head.map(heading))),
      make('tbody', role('rowgroup'), ...rows.map((row) => make('tr', role('row'), ...row.map(cell)))),
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
    if (!document.querySelector('header')) addHeader({ synthetic: false }, links);
    if (!main.querySelector('h1')) main.append(make('h1', {}, failure));
    main.append(problems(error));
  });
}

/** "2026-11-21 19:40", as the server says it (UTC). */
export const dateTime = (iso: string): string => iso.slice(0, 16).replace('T', ' ');
