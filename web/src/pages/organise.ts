/** Collections: making them, how far they are, their links and files. */
import type { Collection, ExportReport, Kind, Progress } from '../collecting/collections.ts';
import { consentGap, consentText, instructionsText } from '../collecting/default_texts.ts';
import { parseQuestions } from '../collecting/questions.ts';
import { jsonFiles, textOf } from '../elements/files.ts';
import { action, field, form, labelled, loggedIn, onlyFor } from '../elements/forms.ts';
import { markdown } from '../elements/markdown.ts';
import { byId, counted, make, run } from '../elements/page.ts';
import { teamsBox } from '../evaluation/teams.ts';
import { api, json } from '../server/api.ts';

interface SplitList {
  readonly splits: readonly { split: string; paths: number; instructions: number; goals_hidden: boolean }[];
}
type Platform = Collection['platform']['kind'];

/** Of names in links, as the server takes them. */
const namePattern = '[a-z0-9_\\-]{1,40}';
/** Of Prolific's completion codes. */
const codePattern = '[A-Za-z0-9_\\-]{1,40}';
const kindTexts: Record<Kind, string> = {
  write: 'People write directions', walk: 'People walk by directions', describe: 'People describe objects (as for REVERIE)',
  find: 'People find described objects, to verify them', guide: 'People guide along a path while they walk it (as for RxR)',
  dialogue: 'Two people talk: navigator and oracle (as for CVDN)',
};
/** Of what a collection has items. */
const itemTexts: Record<Kind, string> = {
  write: 'paths', walk: 'instructions', describe: 'objects', find: 'descriptions', guide: 'paths', dialogue: 'goals',
};
/** Files beside annotations and tasks; and whether all is exported that was not rejected, or only what was accepted. */
const fileTexts: Record<Kind, { readonly file: string; readonly also: readonly (readonly [string, string])[]; readonly checked: boolean }> = {
  write: { file: 'R2R file', also: [], checked: false },
  walk: { file: 'R2R file', also: [['results', 'results'], ['walks', 'walks with times']], checked: true },
  describe: { file: 'REVERIE file', also: [], checked: false },
  find: { file: 'REVERIE file', also: [['results', 'results'], ['walks', 'walks with times']], checked: true },
  guide: { file: 'RxR guide file', also: [['walks', 'pose traces']], checked: false },
  dialogue: { file: 'CVDN file', also: [['dialogues', 'whole dialogues']], checked: true },
};
const languages: Record<string, string> = { 'en-US': 'English (US)', 'en-IN': 'English (India)', 'hi-IN': 'Hindi', 'te-IN': 'Telugu' };
const platformTexts: Record<Platform, string> = { self: 'a link of your own', mturk: 'Mechanical Turk', prolific: 'Prolific' };

function progressOf({ items, places, leased, submitted, accepted, rejected, complete, workers, minutes }: Progress, kind: Kind): HTMLElement {
  const bar = make('progress', { max: String(Math.max(places, 1)), value: String(accepted + submitted), 'aria-label': 'Submitted' });
  const facts = [
    `${complete} of ${items} ${itemTexts[kind]} complete`,
    `${counted(workers, 'worker')}${leased > 0 ? `, ${leased} at work now` : ''}`,
    ...(rejected > 0 ? [`${rejected} rejected`] : []),
    ...(minutes > 0 ? [`A task takes ${minutes < 1 ? 'less than a minute' : `${minutes.toFixed(1)} minutes`} (median)`] : []),
  ];
  return make('div', {}, bar,
    make('p', {}, make('strong', {}, `${accepted + submitted} of ${places} submitted`), `: ${accepted} accepted, ${submitted} to review.`),
    make('p', { class: 'note' }, `${facts.join('. ')}.`));
}

const exportOf = (collection: string, query: Record<string, string>): string =>
  `collections/${encodeURIComponent(collection)}/export?${new URLSearchParams(query)}`;

/** What the reports said, as long as nothing was submitted or reviewed since. */
const reports = new Map<string, Promise<ExportReport>>();
function reportOf(of: Collection, split: string, state: string): Promise<ExportReport> {
  const key = JSON.stringify([of.collection, split, state, of.progress]);
  const known = reports.get(key) ?? api.call<ExportReport>(exportOf(of.collection, { split, state, what: 'report' }));
  reports.set(key, known);
  return known;
}

/**
 * The files to be had, and what they leave out. Walks were checked when they were submitted, so theirs don't wait for a
 * review.
 */
function filesOf(collection: Collection): HTMLElement {
  const { collection: name, kind, splits = [] } = collection;
  const { file, also, checked } = fileTexts[kind];
  const state = checked ? 'all' : 'accepted';
  const link = (split: string, what: string, text: string, of: 'accepted' | 'all' = state) =>
    make('a', { href: `/api/v1/${exportOf(name, { split, what, state: of })}`, download: '' }, text);
  const rows = splits.map(({ split, items, goals_hidden }) => {
    const said = make('p', { class: 'note' });
    reportOf(collection, split, state).then(({ summary }) => { said.textContent = `${summary}.`; }, () => {});
    const dot = (list: readonly HTMLElement[]) => list.flatMap((one) => [one, ' · ']);
    return make('li', {}, `${split} (${items}): `, ...dot([
      ...(goals_hidden ? [] : [link(split, 'annotations', file)]),
      ...(checked ? [] : [link(split, 'annotations', 'with what is not reviewed', 'all')]),
      ...also.map(([what, text]) => link(split, what, text))]),
    link(split, 'tasks', 'all tasks with times'), said);
  });
  return make('div', {}, make('h3', {}, 'Files'),
    make('p', { class: 'note' }, checked ? 'All but what was rejected.' : 'What was accepted.'), make('ul', {}, ...rows));
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

const stateTexts: Record<Collection['state'], string> = { open: 'Open.', closed: 'Closed.', archived: 'Archived.' };

/** Texts and rules of a collection that is there. */
function changeBox(collection: Collection, changed: () => Promise<void>): HTMLElement {
  const { collection: name } = collection;
  const box = make('details', {}, make('summary', {}, 'Change'));
  // Made when it is opened: there may be many collections.
  box.addEventListener('toggle', () => {
    if (!box.open || box.childElementCount > 1) return;
    const [titleBox, title] = field(`title-${name}`, 'Title, for workers', { maxlength: '80', value: collection.title });
    const [consentBox, consent] = prose(`consent-${name}`, 'Consent');
    const [instructionsBox, instructions] = prose(`instructions-${name}`, 'Instructions');
    const rules = ruleFields(`-${name}`, collection);
    consent.value = collection.consent;
    instructions.value = collection.instructions;
    box.append(form('Save', [titleBox, consentBox,
      make('p', { class: 'note' }, 'Workers who agreed to another consent text are asked again.'), instructionsBox, rules.box], async () => {
      await api.call(`collections/${encodeURIComponent(name)}`, json({
        title: title.value.trim(), consent: consent.value, instructions: instructions.value, ...rules.read() }, 'PATCH'));
      await changed();
    }));
  });
  return box;
}

function copyBox(collection: Collection, changed: () => Promise<void>): HTMLElement {
  const { collection: from } = collection;
  const [nameBox, name] = field(`copy-${from}`, 'Name of the copy, in links', { maxlength: '40', pattern: namePattern, value: `${from}-2`.slice(0, 40) });
  return make('details', {}, make('summary', {}, 'Copy'),
    make('p', { class: 'note' }, 'The same paths, texts, questions and rules; none of the work. It is open at once, by a link of its own.'),
    form('Copy', [nameBox], async () => {
      await api.call(`collections/${encodeURIComponent(from)}/copy`, json({ name: name.value }));
      await changed();
    }));
}

/** Rules of a collection that can be changed later, too. @param after the end of the fields' ids */
function ruleFields(after: string, now?: Collection): { box: HTMLElement; read(): object } {
  const number = (id: string, text: string, most: number, note: string, value: number | undefined, attributes: Record<string, string> = {}): [HTMLElement, HTMLInputElement] => {
    const [box, input] = field(id + after, text, { type: 'number', min: '1', max: String(most), placeholder: 'default', ...attributes }, note);
    input.required = false;
    if (value) input.value = String(value);
    return [box, input];
  };
  const [payBox, pay] = field(`pay${after}`, 'Pay, as workers read it', { maxlength: '200', placeholder: '$1.20 a path', ...(now?.pay && { value: now.pay }) });
  pay.required = false;
  const [minutesBox, minutes] = number('minutes', 'Minutes that a task takes', 600, now?.progress?.minutes
    ? `So far the median is ${now.progress.minutes.toFixed(1)}.` : 'Workers see it before they agree.', now?.minutes, { step: '0.5', min: '0.5', placeholder: 'not said' });
  const [perBox, per] = number('per-item', 'Different workers for each', 100, 'Default: 3 where people write, 1 where they walk, 2 for a dialogue, which takes two.', now?.per_item);
  const [leaseBox, lease] = number('lease', 'Minutes until an inactive task goes to another worker', 1440, 'Default: 30.', now?.lease_minutes);
  const [visitBox, visit] = number('visit', 'Tasks per visit', 1000, 'Default: all of them with a link of your own, else 1.', now?.tasks_per_visit);
  const [everyBox, every] = number('check-every', 'Tasks from one attention check to the next', 1000, 'Default: 3.', now?.check_every);
  const more = make('details', {}, make('summary', {}, 'More'), perBox, leaseBox, visitBox, everyBox);
  const optional = (key: string, input: HTMLInputElement) => (input.value ? { [key]: Number(input.value) } : {});
  return {
    box: make('div', {}, payBox, minutesBox, more),
    read: () => ({
      ...(pay.value.trim() !== (now?.pay ?? '') && { pay: pay.value.trim() }), ...optional('minutes', minutes),
      ...optional('per_item', per), ...optional('lease_minutes', lease), ...optional('tasks_per_visit', visit), ...optional('check_every', every),
    }),
  };
}

/** Questions to workers, a block each. */
function questionField(id: string, text: string, note: string): [HTMLElement, HTMLTextAreaElement] {
  return labelled(id, text, make('textarea', { rows: '5', placeholder: 'Are you at least 18 years old?\n* Yes\nNo' }), note);
}

function cardOf(collection: Collection, organiser: boolean, changed: () => Promise<void>): HTMLElement {
  const { collection: name, title, kind, state, platform, progress } = collection;
  const said = make('div', { 'aria-live': 'polite' });
  const card = make('li', { class: 'card' }, make('h2', {}, title), make('p', { class: 'note' },
    `${kindTexts[kind]}, by ${platformTexts[platform.kind]}. ${stateTexts[state]}`));
  if (progress) card.append(progressOf(progress, kind));
  card.append(make('p', {}, make('a', { href: `/review?${new URLSearchParams({ collection: name })}` }, 'Review')));
  if (!organiser) return card;
  const become = (text: string, next: Collection['state']) => action(text, said, async () => {
    await api.call(`collections/${encodeURIComponent(name)}`, json({ state: next }, 'PATCH'));
    await changed();
  }, { 'aria-label': `${text}: ${title}` });
  card.append(linkOf(collection, said), filesOf(collection), changeBox(collection, changed), copyBox(collection, changed), make('p', { class: 'buttons' },
    state === 'open' ? become('Close', 'closed') : become('Open again', 'open'),
    ...(state === 'archived' ? [] : [become('Archive', 'archived')]),
    make('a', { href: `/api/v1/collections/${encodeURIComponent(name)}/workers?format=csv`, download: '' }, 'Visits and payment (CSV)')), said);
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
function sourceFields({ splits }: SplitList): { box: HTMLElement; show(kind: Kind): void; read(kind: Kind): Promise<object[]> } {
  const boxes = splits.map(({ split, paths, goals_hidden }) => {
    const tick = make('input', { type: 'checkbox', value: split });
    return { tick, label: make('label', { class: 'row' }, tick, `${split} (${paths} paths${goals_hidden ? ', goals hidden' : ''})`) };
  });
  const [fileBox, file] = field('paths', splits.length > 0 ? 'Or a file of paths' : 'A file of paths', { type: 'file', accept: jsonFiles },
    'As enfilade sample writes, or any R2R file: path_id, scan, heading, path. Where objects are described or found, and for dialogues, also REVERIE files; for dialogues, CVDN files.');
  file.required = false;
  const [splitBox, split] = field('split', "That file's split, as the export will call it", { value: 'train', pattern: namePattern });
  const [mostBox, most] = field('most', 'Only the first paths of each', { type: 'number', min: '1', placeholder: 'all' });
  most.required = false;
  const [practiceBox, practice] = labelled('practice', 'Practice, for every worker first',
    make('select', {}, new Option('none', ''), ...splits.filter(({ goals_hidden }) => !goals_hidden).map(({ split: name }) => new Option(`the first path of ${name}`, name))),
    'With feedback; it is never reviewed nor exported, and that path is no task.');
  const [objectsBox, objects] = field('objects', 'Objects at the end of each path', { type: 'number', min: '1', max: '20', value: '1' },
    'The largest ones, by the boxes of the data set (REVERIE). A file may name them itself.');
  const [fromBox, from] = field('from', 'Descriptions of this collection', { maxlength: '40', pattern: namePattern },
    'The name, in links, of a collection of descriptions: what was accepted there is to be found here. Or a file of REVERIE.');
  from.required = false;
  const show = (kind: Kind): void => {
    practiceBox.hidden = boxes.length === 0 || kind === 'dialogue' || kind === 'find';
    objectsBox.hidden = kind !== 'describe' && kind !== 'dialogue';
    fromBox.hidden = kind !== 'find';
    list.hidden = boxes.length === 0 || kind === 'find';
  };
  const read = async (kind: Kind): Promise<object[]> => {
    const limit = { ...(most.value && { most: Number(most.value) }), ...(!objectsBox.hidden && { objects: Number(objects.value) }) };
    if (kind === 'find' && from.value) return [{ collection: from.value, ...(most.value && { most: Number(most.value) }) }];
    const first: object[] = practice.value && !practiceBox.hidden ? [{ split: practice.value, most: 1, practice: true }] : [];
    const chosen: object[] = (kind === 'find' ? [] : boxes.filter(({ tick }) => tick.checked)).map(({ tick }) => ({ split: tick.value, ...limit }));
    const [given] = file.files ?? [];
    if (given) chosen.push({ split: split.value, paths: JSON.parse(await textOf(given)) as object[], ...limit });
    if (chosen.length === 0) throw new Error('Choose paths: a split of the data set, or a file.');
    return [...first, ...chosen];
  };
  const list = make('fieldset', {}, make('legend', {}, 'Paths of the data set'), ...boxes.map(({ label }) => make('div', {}, label)));
  show('write');
  return { box: make('div', {}, fromBox, list, fileBox, splitBox, mostBox, objectsBox, practiceBox), show, read };
}

/** Where workers come from, and what that needs. */
function platformFields(): { box: HTMLElement; read(): object } {
  const kinds = Object.entries(platformTexts).map(([value, text]) => new Option(text, value));
  const [box, kind] = labelled('platform', 'Workers come through', make('select', {}, ...kinds));
  const [codeBox, code] = field('code', 'Completion code of the Prolific study', { pattern: codePattern });
  const [outBox, out] = field('screen-out', 'Completion code for workers whom the screening sends away', { pattern: codePattern });
  out.required = false;
  const show = () => {
    codeBox.hidden = outBox.hidden = kind.value !== 'prolific';
    code.required = !codeBox.hidden;
  };
  kind.addEventListener('change', show);
  show();
  return {
    box: make('div', {}, box, codeBox, outBox),
    read: () => ({
      kind: kind.value,
      ...(kind.value === 'prolific' && { completion_code: code.value, ...(out.value && { screen_out_code: out.value }) }),
    }),
  };
}

function newCollection(splits: SplitList, made: () => Promise<void>): HTMLElement {
  const [titleBox, title] = field('title', 'Title, for workers', { maxlength: '80' });
  const [nameBox, name] = field('name', 'Name, in links', { maxlength: '40', pattern: namePattern });
  const kinds = Object.entries(kindTexts).map(([value, text]) => new Option(text, value));
  const [kindBox, kind] = labelled('kind', 'Type of task', make('select', {}, ...kinds));
  const [languageBox, language] = labelled('language', 'Language', make('select', {},
    ...Object.entries(languages).map(([value, text]) => new Option(text, value))), 'One of RxR\'s.');
  languageBox.hidden = true;
  const [consentBox, consent] = prose('consent', 'Consent');
  const [instructionsBox, instructions] = prose('instructions', 'Instructions');
  const rules = ruleFields('');
  const [screeningBox, screening] = questionField('screening', 'Screening: questions after the consent',
    'A question on a line, its choices on the lines below, * before the right ones; an empty line between questions. A wrong answer: no task.');
  const [checksBox, checks] = questionField('checks', 'Attention checks: questions between tasks',
    'Written likewise. Wrong answers are counted; you and the reviewers see them.');
  const asked = make('details', {}, make('summary', {}, 'Questions to workers'), screeningBox, checksBox);
  const [sources, platform] = [sourceFields(splits), platformFields()];
  consent.value = consentText;
  instructions.value = instructionsText.write;
  title.addEventListener('input', () => { name.value = slug(title.value); });
  const lookedUp = make('p', { class: 'note', hidden: '' }, 'Anyone can look up the ends of paths on the page Episodes, in a split whose goals are not hidden. ' +
    'For walks that are paid for, take one with hidden goals, or a file of paths of your own.');
  kind.addEventListener('change', () => {
    instructions.value = instructionsText[kind.value as Kind];
    lookedUp.hidden = kind.value !== 'walk' && kind.value !== 'dialogue';
    languageBox.hidden = kind.value !== 'guide';
    sources.show(kind.value as Kind);
  });
  return form('Create and open', [titleBox, nameBox, kindBox, languageBox, sources.box, lookedUp, platform.box, consentBox, instructionsBox, asked, rules.box], async () => {
    if (consent.value.includes(consentGap)) {
      consent.focus();
      throw new Error(`The consent still says "${consentGap}": say it there.`);
    }
    await api.call('collections', json({
      name: name.value, title: title.value.trim(), kind: kind.value, consent: consent.value, instructions: instructions.value,
      sources: await sources.read(kind.value as Kind), ...(kind.value === 'guide' && { language: language.value }), platform: platform.read(), ...rules.read(),
      screening: parseQuestions(screening.value), checks: parseQuestions(checks.value),
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
  const search = make('input', { type: 'search', 'aria-label': 'Search collections', placeholder: 'Search' });
  const archived = make('input', { type: 'checkbox' });
  const filters = make('div', { class: 'filters' }, search, make('label', { class: 'row' }, archived, 'Show archived'));
  const refresh = async (): Promise<void> => {
    const query = new URLSearchParams({ q: search.value, ...(archived.checked && { state: 'archived' }) });
    const { collections } = await api.call<{ collections: Collection[] }>(`collections?${query}`);
    none.textContent = search.value || archived.checked ? 'No collection matches.' : organiser ? 'No collections yet.' : 'No collections yet; organisers create them.';
    list.replaceChildren(...collections.map((one) => cardOf(one, organiser, refresh)));
    list.hidden = collections.length === 0;
    none.hidden = collections.length > 0;
  };
  const none = make('p');
  const said = make('div', { role: 'status' });
  main.append(make('h1', {}, 'Collections'), loggedIn(who), said, filters, none, list);
  await refresh();
  for (const control of [search, archived]) control.addEventListener('input', () => void refresh());
  setInterval(() => {
    // Not while the organiser uses it, nor over a form that is filled in.
    const used = list.contains(document.activeElement) || list.querySelector('details[open]') !== null;
    if (!document.hidden && !used) refresh().catch(() => {});
  }, 15_000);
  if (!organiser) return;
  const box = make('details', { class: 'new' }, make('summary', {}, make('h2', {}, 'New collection')));
  box.open = !none.hidden;
  box.append(newCollection(await api.call<SplitList>('splits'), async () => {
    box.open = false;
    await refresh();
    said.replaceChildren(make('p', { class: 'done' }, 'The collection is open. Send its link to workers.'));
    scrollTo(0, 0);
  }));
  main.append(box, await teamsBox());
});
