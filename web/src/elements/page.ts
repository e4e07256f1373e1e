/** What all pages have: making elements, the header, telling what went wrong. */
import { api, reachability, ServerError, Silence } from '../server/api.ts';

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
/** Where the server has runs to look at. */
const runsLink: Link = ['/replay', 'Runs'];

/** Pages that the navigation does not have, and the one of it that they belong to. */
const belongsTo: Readonly<Record<string, string>> = {
  '/view': '/', '/roam': '/', '/verify': '/', '/try': '/episodes', '/play': '/episodes', '/submission': '/leaderboard', '/review': '/organise',
};

/** What the header says of a server, as answers about its scans have it. */
export interface Served {
  readonly synthetic: boolean;
  /** Whether there are runs to look at: /replay. */
  readonly runs?: boolean;
}

const headerShown = (): HTMLElement | null => document.querySelector<HTMLElement>('body > .site');

/** The focus goes to the main part. The address stays: on many pages what follows its # names a building, a viewpoint or a step. */
function skipLink(): HTMLElement {
  const link = make('a', { href: '#main', class: 'skip' }, 'Skip to the content');
  link.addEventListener('click', (event) => {
    event.preventDefault();
    const main = byId('main');
    main.tabIndex = -1;
    main.addEventListener('blur', () => main.removeAttribute('tabindex'), { once: true });
    main.focus();
  });
  return link;
}

/**
 * The header before the page's main part. What it does not yet say of the server has its room: nothing moves when it does.
 * @param current the address of the link that is marked
 */
function putHeader(links: readonly Link[], current: string): HTMLElement {
  const header = make('header', { class: 'site' },
    links.length > 0 ? make('a', { href: '/', class: 'name' }, 'Enfilade') : make('span', { class: 'name' }, 'Enfilade'));
  const nav = make('nav', { 'aria-label': 'Pages', class: 'site-links' }, ...links.map(([href, text]) =>
    make('a', { href, ...(href === current && { 'aria-current': location.pathname === href ? 'page' : 'true' }) }, text)));
  for (const runs of nav.querySelectorAll<HTMLElement>(`[href='${runsLink[0]}']:not([aria-current])`)) runs.hidden = true;
  if (links.length > 0) header.append(nav);
  const badge = make('span', { class: 'badge synthetic', title: 'The buildings here are made by a program; they are not real ones' },
    'Model homes: SYNTHETIC');
  badge.hidden = true;
  header.append(badge);
  document.body.prepend(skipLink(), header);
  const marked = nav.querySelector<HTMLElement>('[aria-current]');
  if (marked) nav.scrollLeft = marked.offsetLeft + marked.offsetWidth - nav.offsetLeft - nav.clientWidth; // on phones
  tellSilence();
  return header;
}

/** What the header says of the server. Puts the header there first if there is none: of workers, who get no links. */
export function addHeader({ synthetic, runs = false }: Served, links: readonly Link[] = [...siteLinks, runsLink]): HTMLElement {
  const header = headerShown() ?? putHeader(links, location.pathname);
  header.dataset['told'] = '';
  header.querySelector<HTMLElement>('.synthetic')!.hidden = !synthetic;
  for (const link of header.querySelectorAll<HTMLElement>(`[href='${runsLink[0]}']:not([aria-current])`)) link.hidden = !runs;
  return header;
}

/** As addHeader(), of a page that shows no building by itself: the server is asked. No page waits for it. */
export async function addSiteHeader(): Promise<void> {
  addHeader({ synthetic: false });
  api.call<Served>('scans').then(addHeader, () => {}); // another line says that the server does not answer
}

/** One line while the server does not answer. */
function tellSilence(): void {
  const line = make('p', { class: 'silence', role: 'alert' }, 'The server does not answer. Trying again…');
  reachability.addEventListener('lost', () => document.body.append(line));
  reachability.addEventListener('back', () => line.remove());
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

/** A message, with the problems of a file in a list. That the server does not answer is true only until it does. */
export function problems(error: unknown): HTMLElement {
  // The server's sentences begin small, as a program's do; a field's name stays as it is.
  const message = (error instanceof Error ? error.message : String(error)).replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase());
  const box = make('div', { role: 'alert' }, make('p', { class: 'problem' }, message));
  if (error instanceof Silence) reachability.addEventListener('back', () => box.remove(), { once: true });
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
 * Runs a page: its header is there at once, and what goes wrong is shown on it, with a way back.
 * @param failure the heading then, where there is none yet
 * @param current the page of the navigation that this one belongs to
 */
export function run(
  page: () => Promise<void>, failure = 'This page cannot be shown', current = belongsTo[location.pathname] ?? location.pathname,
): void {
  const links = [...siteLinks, runsLink];
  const header = putHeader(links, current);
  page().catch((error: unknown) => {
    const main = byId('main');
    if (main.classList.contains('wide')) main.replaceChildren(); // an empty view
    main.classList.remove('wide');
    if (!main.querySelector('h1')) main.append(make('h1', {}, failure));
    main.append(problems(error));
    const [href, name] = links.find(([address]) => address === current) ?? links[0]!;
    if (location.pathname + location.search + location.hash !== href) {
      main.append(make('p', { class: 'buttons' }, make('a', { href, class: 'button' }, `Go to ${name}`)));
    }
    if (error instanceof Silence) reachability.addEventListener('back', () => location.reload(), { once: true });
  }).finally(() => {
    if (header.dataset['told'] === undefined) void addSiteHeader();
  });
}

/** "2026-11-21 19:40", as the server says it (UTC). */
export const dateTime = (iso: string): string => iso.slice(0, 16).replace('T', ' ');
