/** A collection as a card: how far it is, what to do next, and behind a menu all that can be done with it. */
import { dayChart } from '../elements/day_chart.ts';
import { action, field, form, labelled } from '../elements/forms.ts';
import { menu } from '../elements/menu.ts';
import { counted, make } from '../elements/page.ts';
import { api, json } from '../server/api.ts';
import { addressOf, reviewPage } from './addresses.ts';
import type { Collection, ExportReport, Kind, Progress } from './collections.ts';
import { itemTexts, kindTexts, platformTexts } from './kind_texts.ts';
import type { Preview } from './new_collection.ts';
import { namePattern, prose, ruleFields } from './text_fields.ts';

/** What a card asks its page for. */
export interface CardHost {
  readonly organiser: boolean;
  /** After something was changed. */
  changed(): Promise<void>;
  preview(preview: Preview): Promise<void>;
}

interface FileTexts {
  readonly file: string;
  /** Beside annotations and tasks. */
  readonly also: readonly (readonly [string, string])[];
  /** Whether all is exported that was not rejected, or only what was accepted. */
  readonly checked: boolean;
}
const fileTexts: Readonly<Record<Kind, FileTexts>> = {
  write: { file: 'R2R file', also: [], checked: false },
  walk: { file: 'R2R file', also: [['results', 'results'], ['walks', 'walks with times']], checked: true },
  describe: { file: 'REVERIE file', also: [], checked: false },
  find: { file: 'REVERIE file', also: [['results', 'results'], ['walks', 'walks with times']], checked: true },
  guide: { file: 'RxR guide file', also: [['walks', 'pose traces']], checked: false },
  dialogue: { file: 'CVDN file', also: [['dialogues', 'whole dialogues']], checked: true },
};
const stateTexts: Readonly<Record<Collection['state'], string>> = { open: 'Open.', closed: 'Closed.', archived: 'Archived.' };

function progressOf({ items, places, leased, submitted, accepted, rejected, complete, workers, minutes, days }: Progress, kind: Kind): HTMLElement {
  const bar = make('progress', { max: String(Math.max(places, 1)), value: String(accepted + submitted), 'aria-label': 'Submitted' });
  const facts = [
    `${complete} of ${counted(items, itemTexts[kind])} complete`,
    `${counted(workers, 'worker')}${leased > 0 ? `, ${leased} at work now` : ''}`,
    ...(rejected > 0 ? [`${rejected} rejected`] : []),
    ...(minutes > 0 ? [`A task takes ${minutes < 1 ? 'less than a minute' : `${minutes.toFixed(1)} minutes`} (median)`] : []),
  ];
  return make('div', {}, bar,
    make('p', {}, make('strong', {}, `${accepted + submitted} of ${places} submitted`), `: ${accepted} accepted, ${submitted} to review.`),
    make('p', { class: 'note' }, `${facts.join('. ')}.`), ...dayChart(days));
}

const exportOf = (collection: string, query: Record<string, string>): string => `${addressOf(collection)}/export?${new URLSearchParams(query)}`;

/** What the reports said, as long as nothing was submitted or reviewed since. */
const reports = new Map<string, Promise<ExportReport>>();
function reportOf(of: Collection, split: string, state: string): Promise<ExportReport> {
  const key = JSON.stringify([of.collection, split, state, of.progress]);
  const known = reports.get(key) ?? api.call<ExportReport>(exportOf(of.collection, { split, state, what: 'report' }));
  reports.set(key, known);
  known.catch(() => reports.delete(key)); // is asked for again
  return known;
}

/**
 * The files to be had, and what they leave out. Walks were checked when they were submitted, so theirs don't wait for a
 * review.
 */
function filesOf(collection: Collection): HTMLElement {
  const { collection: name, kind, title, splits = [] } = collection;
  const { file, also, checked } = fileTexts[kind];
  const state = checked ? 'all' : 'accepted';
  const link = (split: string, what: string, text: string, of: 'accepted' | 'all' = state) =>
    make('a', { href: `/api/v1/${exportOf(name, { split, what, state: of })}`, download: '' }, text);
  const rows = () => splits.map(({ split, items, goals_hidden }) => {
    const said = make('p', { class: 'note' });
    reportOf(collection, split, state).then(({ summary }) => { said.textContent = `${summary}.`; }, () => {});
    const dot = (list: readonly HTMLElement[]) => list.flatMap((one) => [one, ' · ']);
    return make('li', {}, `${split} (${items}): `, ...dot([
      ...(goals_hidden ? [] : [link(split, 'annotations', file)]),
      ...(checked ? [] : [link(split, 'annotations', 'with what is not reviewed', 'all')]),
      ...also.map(([what, text]) => link(split, what, text))]),
    link(split, 'tasks', 'all tasks with times'), said);
  });
  const box = make('details', {}, make('summary', { 'aria-label': `Files: ${title}` }, 'Files'));
  box.addEventListener('toggle', () => {
    if (!box.open || box.childElementCount > 1) return;
    box.append(make('p', { class: 'note' }, checked ? 'All but what was rejected.' : 'What was accepted.'), make('ul', {}, ...rows()));
  });
  return box;
}

/** The page for workers, whose address is longer than its box. @param main there is nothing else to do first */
function linkOf({ collection, title, platform, link = '' }: Collection, said: HTMLElement, main: boolean): HTMLElement {
  const text = make('input', { type: 'text', readonly: '', value: location.origin + link });
  const [box] = labelled(`link-${collection}`, platform.kind === 'mturk' ? 'ExternalURL of the HIT' : 'Link for workers', text);
  const copy = action('Copy the link', said, async () => {
    text.select();
    if (!isSecureContext) throw new Error('The link is selected: copy it by Ctrl+C.'); // no clipboard but by TLS or at home
    await navigator.clipboard.writeText(text.value);
    said.replaceChildren(make('p', { class: 'done' }, 'Copied.'));
  }, { 'aria-label': `Copy the link: ${title}`, ...(main && { class: 'main' }) });
  box.append(make('div', { class: 'copied' }, text, copy));
  return box;
}

/** Texts and rules of a collection that is there. */
function changeForm(collection: Collection, changed: () => Promise<void>): HTMLElement {
  const { collection: name } = collection;
  const [titleBox, title] = field(`title-${name}`, 'Title, for workers', { maxlength: '80', value: collection.title });
  const [consentBox, consent] = prose(`consent-${name}`, 'Consent');
  const [instructionsBox, instructions] = prose(`instructions-${name}`, 'Instructions');
  const rules = ruleFields(`-${name}`, collection);
  consent.value = collection.consent;
  instructions.value = collection.instructions;
  return form('Save', [titleBox, consentBox,
    make('p', { class: 'note' }, 'Workers who agreed to another consent text are asked again.'), instructionsBox, rules.box], async () => {
    await api.call(addressOf(name), json({
      title: title.value.trim(), consent: consent.value, instructions: instructions.value, ...rules.read() }, 'PATCH'));
    await changed();
  });
}

function copyForm({ collection: from }: Collection, changed: () => Promise<void>): HTMLElement {
  const [nameBox, name] = field(`copy-${from}`, 'Name of the new collection, in links',
    { maxlength: '40', pattern: namePattern, value: `${from}-2`.slice(0, 40) },
    'It has the same paths, texts, questions and rules, and none of the work. It is open at once, with another link.');
  return form('Make the copy', [nameBox], async () => {
    await api.call(`${addressOf(from)}/copy`, json({ name: name.value }));
    await changed();
  });
}

/** What else can be done, by an organiser or a reviewer. @param panel where forms open */
function menuOf(collection: Collection, { organiser, changed, preview }: CardHost, panel: HTMLElement, said: HTMLElement): HTMLElement {
  const { collection: name, title, state } = collection;
  const link = (text: string, href: string, more: Record<string, string> = {}) => make('a', { href, ...more }, text);
  const opens = (text: string, content: () => HTMLElement) => {
    const button = make('button', { type: 'button', 'aria-label': `${text}: ${title}` }, text);
    button.addEventListener('click', () => {
      const cancel = make('button', { type: 'button' }, 'Cancel');
      cancel.addEventListener('click', () => panel.replaceChildren());
      panel.replaceChildren(make('h3', { tabindex: '-1' }, text), content(), make('p', {}, cancel));
      panel.querySelector<HTMLElement>('h3')!.focus();
    });
    return button;
  };
  const become = (text: string, next: Collection['state']) => action(text, said, async () => {
    await api.call(addressOf(name), json({ state: next }, 'PATCH'));
    await changed();
  }, { 'aria-label': `${text}: ${title}` });
  const look = action('Preview a task', said, async () => preview(await api.call<Preview>(`${addressOf(name)}/example`)),
    { 'aria-label': `Preview a task: ${title}` });
  const reviewing = [link('All work, as a table', reviewPage(name, { view: 'table' })),
    link('Agreement and checks', reviewPage(name, { view: 'agreement' })), look];
  return menu('More', `More: ${title}`, !organiser ? reviewing : [...reviewing,
    opens('Change texts and rules', () => changeForm(collection, changed)), opens('Make a copy', () => copyForm(collection, changed)),
    link('Visits and payment (CSV)', `/api/v1/${addressOf(name)}/workers?format=csv`, { download: '' }),
    state === 'open' ? become('Close', 'closed') : become('Open again', 'open'),
    ...(state === 'archived' ? [] : [become('Archive', 'archived')])]);
}

/** The card; its element has the collection's name as data-collection. */
export function cardOf(collection: Collection, host: CardHost): HTMLElement {
  const { collection: name, title, kind, state, platform, progress } = collection;
  const said = make('div', { 'aria-live': 'polite' });
  const panel = make('div', { class: 'card-panel' });
  const waiting = progress?.submitted ?? 0;
  const act = waiting > 0 ? `Review ${waiting}` : 'Review';
  const review = make('a', { href: reviewPage(name), class: waiting > 0 ? 'button main' : 'button', 'aria-label': `${act}: ${title}` }, act);
  return make('li', { class: 'card', 'data-collection': name }, make('h2', { tabindex: '-1' }, title), make('p', { class: 'note' },
    `${kindTexts[kind]}. Workers come by ${platformTexts[platform.kind]}. ${stateTexts[state]}`),
  ...(progress ? [progressOf(progress, kind)] : []),
  make('p', { class: 'buttons' }, review, menuOf(collection, host, panel, said)),
  ...(host.organiser ? [linkOf(collection, said, waiting === 0 && state === 'open'), filesOf(collection)] : []), panel, said);
}
