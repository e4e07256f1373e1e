/** Collections: making them, how far they are, their links and files. */
import type { Collection, Progress } from '../collections.ts';
import { action, field, form, labelled, loggedIn, onlyFor } from '../forms.ts';
import { markdown } from '../markdown.ts';
import { api, byId, json, make, run } from '../page.ts';
import { consentGap, consentText, instructionsText } from '../texts.ts';

interface SplitList {
  readonly splits: readonly { split: string; paths: number; instructions: number; goals_hidden: boolean }[];
}
type Kind = Collection['kind'];
type Platform = Collection['platform']['kind'];

const kindTexts: Record<Kind, string> = { write: 'People write directions', walk: 'People walk by directions' };
const platformTexts: Record<Platform, string> = { self: 'a link of your own', mturk: 'Mechanical Turk', prolific: 'Prolific' };

function progressOf({ items, places, leased, submitted, accepted, rejected, complete, workers }: Progress, kind: Kind): HTMLElement {
  const bar = make('progress', { max: String(Math.max(places, 1)), value: String(accepted + submitted), 'aria-label': 'Handed in' });
  const facts = [
    `${complete} of ${items} ${kind === 'write' ? 'paths' : 'instructions'} complete`,
    `${workers} worker${workers === 1 ? '' : 's'}${leased > 0 ? `, ${leased} at work now` : ''}`,
    ...(rejected > 0 ? [`${rejected} rejected`] : []),
  ];
  return make('div', {}, bar,
    make('p', {}, make('strong', {}, `${accepted + submitted} of ${places} handed in`), `: ${accepted} accepted, ${submitted} to review.`),
    make('p', { class: 'note' }, `${facts.join('. ')}.`));
}

/** The files to be had. Walks were checked when they were handed in, so theirs don't wait for a review. */
function filesOf({ collection, kind, splits = [] }: Collection): HTMLElement {
  const link = (split: string, what: string, text: string, state: 'accepted' | 'all') =>
    make('a', { href: `/api/v1/collections/${encodeURIComponent(collection)}/export?${new URLSearchParams({ split, what, state })}`, download: '' }, text);
  const rows = splits.map(({ split, items, goals_hidden }) => make('li', {}, `${split} (${items}): `, ...(kind === 'write'
    ? [link(split, 'annotations', 'R2R file', 'accepted'), ' · ', link(split, 'annotations', 'with what is not reviewed', 'all')]
    : [...(goals_hidden ? [] : [link(split, 'annotations', 'R2R file', 'all'), ' · ']),
      link(split, 'results', 'results', 'all'), ' · ', link(split, 'walks', 'walks with times', 'all')])));
  return make('div', {}, make('h3', {}, 'Files'),
    make('p', { class: 'note' }, kind === 'write' ? 'What was accepted.' : 'All walks but the rejected ones.'), make('ul', {}, ...rows));
}

/** The page for workers, which is longer than its box. */
function linkOf({ collection, title, platform, link = '' }: Collection, said: HTMLElement): HTMLElement {
  const text = make('input', { type: 'text', readonly: '', value: location.origin + link });
  const [box] = labelled(`link-${collection}`, platform.kind === 'mturk' ? 'ExternalURL of the HIT' : 'Link for workers', text);
  const copy = action('Copy', said, async () => {
    text.select();
    if (!isSecureContext) throw new Error('The link is selected: copy it by Ctrl+C.'); // no clipboard but by TLS or at home
    await navigator.clipboard.writeText(text.value);
    said.replaceChildren(make('p', { class: 'done' }, 'Copied.'));
  }, { 'aria-label': `Copy the link: ${title}` });
  box.append(make('div', { class: 'copied' }, text, copy));
  return box;
}

function cardOf(collection: Collection, organiser: boolean, changed: () => Promise<void>): HTMLElement {
  const { collection: name, title, kind, state, platform, progress } = collection;
  const said = make('div', { 'aria-live': 'polite' });
  const card = make('li', { class: 'card' }, make('h2', {}, title), make('p', { class: 'note' },
    `${kindTexts[kind]}, by ${platformTexts[platform.kind]}. ${state === 'open' ? 'Open.' : 'Closed.'}`));
  if (progress) card.append(progressOf(progress, kind));
  card.append(make('p', {}, make('a', { href: `/review?${new URLSearchParams({ collection: name })}` }, 'Review')));
  if (!organiser) return card;
  const other = state === 'open' ? 'closed' : 'open';
  card.append(linkOf(collection, said), filesOf(collection), make('p', { class: 'buttons' },
    action(state === 'open' ? 'Close' : 'Open again', said, async () => {
      await api.call(`collections/${encodeURIComponent(name)}`, json({ state: other }, 'PATCH'));
      await changed();
    }, { 'aria-label': `${state === 'open' ? 'Close' : 'Open again'}: ${title}` }),
    make('a', { href: `/api/v1/collections/${encodeURIComponent(name)}/workers?format=csv`, download: '' }, 'Visits, for paying (CSV)')), said);
  return card;
}

/** A text in Markdown, and how it will look. */
function prose(id: string, text: string): [HTMLElement, HTMLTextAreaElement] {
  const shown = make('div');
  const look = make('details', {}, make('summary', {}, 'As workers see it'), shown);
  const [box, area] = labelled(id, text, make('textarea', { rows: '9', maxlength: '20000', required: '' }), 'Markdown; HTML is shown as text.');
  const show = () => { if (look.open) shown.replaceChildren(markdown(area.value)); };
  look.addEventListener('toggle', show);
  area.addEventListener('input', show);
  box.append(look);
  return [box, area];
}

const slug = (title: string): string =>
  title.toLowerCase().normalize('NFD').replace(/[^a-z0-9]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 40);

/** Which paths: splits of the data set, or a file. */
function sourceFields({ splits }: SplitList): { box: HTMLElement; read(): Promise<object[]> } {
  const boxes = splits.map(({ split, paths, goals_hidden }) => {
    const tick = make('input', { type: 'checkbox', value: split });
    return { tick, label: make('label', { class: 'row' }, tick, `${split} (${paths} paths${goals_hidden ? ', goals hidden' : ''})`) };
  });
  const [fileBox, file] = field('paths', splits.length > 0 ? 'Or a file of paths' : 'A file of paths', { type: 'file', accept: '.json,application/json' },
    'As enfilade sample writes, or any R2R file: path_id, scan, heading, path.');
  file.required = false;
  const [splitBox, split] = field('split', "That file's split, as the export will call it", { value: 'train', pattern: '[a-z0-9_\\-]{1,40}' });
  const [mostBox, most] = field('most', 'Only the first paths of each', { type: 'number', min: '1', placeholder: 'all' });
  most.required = false;
  const read = async (): Promise<object[]> => {
    const limit = most.value ? { most: Number(most.value) } : {};
    const chosen: object[] = boxes.filter(({ tick }) => tick.checked).map(({ tick }) => ({ split: tick.value, ...limit }));
    const [given] = file.files ?? [];
    if (given) chosen.push({ split: split.value, paths: JSON.parse(await given.text()) as object[], ...limit });
    if (chosen.length === 0) throw new Error('Choose paths: a split of the data set, or a file.');
    return chosen;
  };
  const list = make('fieldset', {}, make('legend', {}, 'Paths of the data set'), ...boxes.map(({ label }) => make('div', {}, label)));
  list.hidden = boxes.length === 0;
  return { box: make('div', {}, list, fileBox, splitBox, mostBox), read };
}

/** Where workers come from, and what that needs. */
function platformFields(): { box: HTMLElement; read(): object } {
  const kinds = Object.entries(platformTexts).map(([value, text]) => new Option(text, value));
  const [box, kind] = labelled('platform', 'Workers come by', make('select', {}, ...kinds));
  const [codeBox, code] = field('code', 'Completion code of the Prolific study', { pattern: '[A-Za-z0-9_\\-]{1,40}' });
  const show = () => {
    codeBox.hidden = kind.value !== 'prolific';
    code.required = !codeBox.hidden;
  };
  kind.addEventListener('change', show);
  show();
  return {
    box: make('div', {}, box, codeBox),
    read: () => ({ kind: kind.value, ...(kind.value === 'prolific' && { completion_code: code.value }) }),
  };
}

function newCollection(splits: SplitList, made: () => Promise<void>): HTMLElement {
  const [titleBox, title] = field('title', 'Title, for workers', { maxlength: '80' });
  const [nameBox, name] = field('name', 'Name, in links', { maxlength: '40', pattern: '[a-z0-9_\\-]{1,40}' });
  const kinds = Object.entries(kindTexts).map(([value, text]) => new Option(text, value));
  const [kindBox, kind] = labelled('kind', 'What is done', make('select', {}, ...kinds));
  const [consentBox, consent] = prose('consent', 'Consent');
  const [instructionsBox, instructions] = prose('instructions', 'Instructions');
  const number = (id: string, text: string, most: number, note: string): [HTMLElement, HTMLInputElement] => {
    const [box, input] = field(id, text, { type: 'number', min: '1', max: String(most), placeholder: 'default' }, note);
    input.required = false;
    return [box, input];
  };
  const [perBox, per] = number('per-item', 'Different workers for each', 100, 'Default: 3 for a path to describe, 1 for an instruction to walk.');
  const [leaseBox, lease] = number('lease', 'Minutes until a task that lies still is given to another', 1440, 'Default: 30.');
  const [visitBox, visit] = number('visit', 'Tasks a visit', 1000, 'Default: by a link of your own as many as there are, else 1.');
  const [sources, platform] = [sourceFields(splits), platformFields()];
  consent.value = consentText;
  instructions.value = instructionsText.write;
  title.addEventListener('input', () => { name.value = slug(title.value); });
  const lookedUp = make('p', { class: 'note', hidden: '' }, 'Everybody can look up where paths end, in a split whose goals are not hidden, on the page Episodes. ' +
    'For walks that are paid for, take one with hidden goals, or a file of paths of your own.');
  kind.addEventListener('change', () => {
    instructions.value = instructionsText[kind.value as Kind];
    lookedUp.hidden = kind.value !== 'walk';
  });
  const more = make('details', {}, make('summary', {}, 'More'), perBox, leaseBox, visitBox);
  const optional = (key: string, input: HTMLInputElement) => (input.value ? { [key]: Number(input.value) } : {});
  return form('Make it, and open it', [titleBox, nameBox, kindBox, sources.box, lookedUp, platform.box, consentBox, instructionsBox, more], async () => {
    if (consent.value.includes(consentGap)) {
      consent.focus();
      throw new Error(`The consent still says "${consentGap}": say it there.`);
    }
    await api.call('collections', json({
      name: name.value, title: title.value.trim(), kind: kind.value, consent: consent.value, instructions: instructions.value,
      sources: await sources.read(), platform: platform.read(),
      ...optional('per_item', per), ...optional('lease_minutes', lease), ...optional('tasks_per_visit', visit),
    }));
    await made();
  });
}

run(async () => {
  const who = await onlyFor(['organiser', 'reviewer'], 'Collections');
  if (!who) return;
  const organiser = who.role === 'organiser';
  const list = make('ul', { class: 'collections', 'aria-label': 'Collections' });
  const main = byId('main');
  const refresh = async (): Promise<void> => {
    const { collections } = await api.call<{ collections: Collection[] }>('collections');
    list.replaceChildren(...collections.map((one) => cardOf(one, organiser, refresh)));
    list.hidden = collections.length === 0;
    none.hidden = collections.length > 0;
  };
  const none = make('p', {}, organiser ? 'There is none yet.' : 'There is none yet; organisers make them.');
  const said = make('div', { role: 'status' });
  main.append(make('h1', {}, 'Collections'), loggedIn(who), said, none, list);
  await refresh();
  setInterval(() => {
    // Not under the hands of somebody who is using it.
    if (!document.hidden && !list.contains(document.activeElement)) refresh().catch(() => {});
  }, 15_000);
  if (!organiser) return;
  const box = make('details', { class: 'new' }, make('summary', {}, make('h2', {}, 'Make a collection')));
  box.open = !none.hidden;
  box.append(newCollection(await api.call<SplitList>('splits'), async () => {
    box.open = false;
    await refresh();
    said.replaceChildren(make('p', { class: 'done' }, 'It is made. Send its link to workers.'));
    scrollTo(0, 0);
  }));
  main.append(box);
});
