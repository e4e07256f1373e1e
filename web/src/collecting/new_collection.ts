/** The form for a new collection: what people do, by which paths, with which texts, and who they are. */
import { action, field, form, labelled } from '../elements/forms.ts';
import { counted, make } from '../elements/page.ts';
import { api, json } from '../server/api.ts';
import type { Collection, Example, Kind } from './collections.ts';
import { consentGap, consentText, instructionsText } from './default_texts.ts';
import { itemTexts, kindTexts, platformTexts } from './kind_texts.ts';
import { parseQuestions } from './questions.ts';
import { sourceFields, type SplitList } from './source_fields.ts';
import { namePattern, prose, questionField, ruleFields } from './text_fields.ts';

/** What a collection would have, as the server says it before there is one. */
export interface Preview {
  readonly collection: Collection;
  readonly example: Example;
  readonly items?: number;
  readonly paths?: number;
  readonly objects?: readonly { readonly name: string; readonly items: number }[];
}

/** What Prolific's completion codes look like. */
const codePattern = '[A-Za-z0-9_\\-]{1,40}';
const languages: Record<string, string> = { 'en-US': 'English (US)', 'en-IN': 'English (India)', 'hi-IN': 'Hindi', 'te-IN': 'Telugu' };

const slug = (title: string): string =>
  title.toLowerCase().normalize('NFD').replace(/[^a-z0-9]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 40);

/** The instructions after a change of the kind: a draft makes room for the other kind's, an organiser's own text stays. */
export const instructionsAfter = (text: string, kind: Kind): string =>
  Object.values(instructionsText).includes(text) ? instructionsText[kind] : text;

/** "12 objects on 9 paths: 3 × bed, chest of drawers." */
export function summaryOf({ collection, items = 0, paths = 0, objects }: Preview): string {
  const one = itemTexts[collection.kind];
  const where = items === paths && one === 'path' ? '' : ` on ${counted(paths, 'path')}`;
  const names = objects ? `: ${objects.map(({ name, items: many }) => (many > 1 ? `${many} × ${name}` : name)).join(', ')}` : '';
  return `${counted(items, one)}${where}${names}.`;
}

/** Where workers come from, and what that needs. */
function platformFields(): { box: HTMLElement; read(): object } {
  const kinds = Object.entries(platformTexts).map(([value, text]) => new Option(text, value));
  const [box, kind] = labelled('platform', 'Workers come by', make('select', {}, ...kinds));
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

const group = (title: string, ...fields: HTMLElement[]): HTMLElement =>
  make('fieldset', { class: 'group' }, make('legend', {}, title), ...fields);

/**
 * A form without anything in it of those before.
 * @param made gets the new collection  @param look shows a preview
 */
export function newCollection(
  splits: SplitList, made: (collection: Collection) => Promise<void>, look: (preview: Preview) => Promise<void>,
): HTMLElement {
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
  const chosen = (): Kind => kind.value as Kind;
  const lookedUp = make('p', { class: 'note', hidden: '' },
    'Anyone can look up the ends of paths on the page Episodes, in a split whose goals are not hidden. ' +
    'For walks that are paid for, take one with hidden goals, or a file of paths of your own.');
  const draft = make('button', { type: 'button', hidden: '' }, 'Replace them by the draft for this type');
  instructionsBox.append(make('p', {}, draft));
  draft.addEventListener('click', () => {
    instructions.value = instructionsText[chosen()];
    draft.hidden = true;
    instructions.focus();
  });
  kind.addEventListener('change', () => {
    instructions.value = instructionsAfter(instructions.value, chosen());
    draft.hidden = instructions.value === instructionsText[chosen()];
    lookedUp.hidden = chosen() !== 'walk' && chosen() !== 'dialogue';
    languageBox.hidden = chosen() !== 'guide';
    sources.show(chosen());
  });
  const read = async (): Promise<object> => ({
    name: name.value, title: title.value.trim(), kind: chosen(), consent: consent.value, instructions: instructions.value,
    sources: await sources.read(chosen()), ...(chosen() === 'guide' && { language: language.value }), platform: platform.read(), ...rules.read(),
    screening: parseQuestions(screening.value), checks: parseQuestions(checks.value),
  });
  const [said, contents] = [make('div'), make('p', { class: 'note', role: 'status' })];
  const preview = action('Preview a task', said, async () => {
    const wanted = await read() as { name: string; title: string };
    const named = { ...wanted, name: wanted.name || 'preview', title: wanted.title || 'Preview' };
    const found = await api.call<Preview>('collections/preview', json(named));
    contents.textContent = `It would have ${summaryOf(found)}`;
    await look(found);
  });
  const element = form('Create and open', [make('div', { class: 'groups' },
    make('div', {}, group('What people do', titleBox, nameBox, kindBox, languageBox), group('Paths', sources.box, lookedUp)),
    make('div', {}, group('Texts', consentBox, instructionsBox), group('People', platform.box, rules.box, asked)))], async () => {
    if (consent.value.includes(consentGap)) {
      consent.focus();
      throw new Error(`The consent still says "${consentGap}": say it there.`);
    }
    await made(await api.call<Collection>('collections', json(await read())));
  });
  const create = element.querySelector('button.main')!;
  create.parentElement!.className = 'buttons';
  create.after(preview);
  element.append(said, contents);
  return element;
}
