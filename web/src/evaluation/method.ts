/** The method of a submission: what its team says of it, and the form in which it does. */
import { field, form, labelled } from '../elements/forms.ts';
import { linkCopier } from '../elements/link_copier.ts';
import { markdown } from '../elements/markdown.ts';
import { make, toast } from '../elements/page.ts';
import { api, json } from '../server/api.ts';
import type { Mean, Row } from './ranking.ts';

/** A submission as its team sees it in its history, and everybody in a leaderboard. */
export interface Submission extends Omit<Row, 'means'> {
  readonly phase: string;
  readonly state: string;
  readonly means?: Readonly<Record<string, Mean>>;
  readonly withheld?: 'until-end' | 'no-improvement' | 'not-best' | 'hidden' | 'other-scorer';
  readonly near_copy?: { readonly of: number; readonly differing: number };
  readonly warnings?: readonly string[];
}

export interface Method extends Submission {
  /** Markdown. */
  readonly description: string;
  readonly bibtex: string;
  /** Whether this browser's user may change it. */
  readonly own: boolean;
  /** Whether there are scores in parts. */
  readonly broken_down: boolean;
}

/** Why a submission has no scores. */
export const withheldTexts: Record<NonNullable<Submission['withheld']>, string> = {
  'until-end': 'Scores appear when the phase has ended',
  'no-improvement': "Not a step better than your team's best",
  'not-best': 'Another submission stands for your team',
  hidden: 'Only the organisers see its scores',
  'other-scorer': 'Scored before the phase was changed, by another scorer',
};

export const methodLink = (id: number): string => `/submission?${new URLSearchParams({ id: String(id) })}`;

/** Links to a method's paper and code. The server takes none but those that begin with https:// */
export function methodLinks(
  { method, paper, code }: Pick<Row, 'method' | 'paper' | 'code'>, attributes: Record<string, string> = {},
): HTMLElement[] {
  const link = (href: string, text: string) =>
    make('a', { href, rel: 'noopener noreferrer nofollow', 'aria-label': `${text} of ${method}`, ...attributes }, text);
  return [...(paper ? [link(paper, 'Paper')] : []), ...(code ? [link(code, 'Code')] : [])];
}

/** A text that people copy, with a button. */
export function copied(text: string, label: string): HTMLElement {
  const { button, said } = linkCopier('Copy', label, () => text, 'Copied');
  return make('div', { class: 'copied-text' }, make('pre', { tabindex: '0', 'aria-label': label, role: 'group' }, text),
    make('p', { class: 'buttons' }, button, said));
}

/** What its team says; for its team also that it says nothing. */
export function aboutMethod(method: Method): HTMLElement[] {
  const links = methodLinks(method, { class: 'button' });
  return [
    ...(method.description ? [markdown(method.description)] : []),
    ...(method.own && !method.description ? [make('p', { class: 'note' }, 'Nothing is said of this method yet.')] : []),
    ...(links.length > 0 ? [make('p', { class: 'buttons' }, ...links)] : []),
    ...(method.bibtex ? [make('details', {}, make('summary', {}, 'BibTeX'), copied(method.bibtex, 'BibTeX'))] : []),
  ];
}

const longest = '5000';

/** @param openGoals whether the submission's trajectories can be shown to everybody */
export function methodForm(method: Method, openGoals: boolean, saved: (method: Method) => void): HTMLElement {
  const [textBox, text] = labelled('description', 'Description', make('textarea', { rows: '6', maxlength: longest }), 'Markdown.');
  text.value = method.description;
  const [bibtexBox, bibtex] = labelled('bibtex', 'BibTeX', make('textarea', { rows: '4', maxlength: longest, spellcheck: 'false' }));
  bibtex.value = method.bibtex;
  const link = { type: 'url', maxlength: '300', pattern: 'https://.*', placeholder: 'https://' };
  const [paperBox, paper] = field('paper', 'Paper', link);
  const [codeBox, code] = field('code', 'Code', link);
  paper.required = code.required = false;
  [paper.value, code.value] = [method.paper ?? '', method.code ?? ''];
  const [weightsBox, weights] = labelled('weights', 'Weights', make('select', {},
    new Option('not said', 'unsaid'), new Option('open: others can have them', 'open'), new Option('closed', 'closed')));
  weights.value = method.weights ?? 'unsaid';
  const walks = make('input', { type: 'checkbox' });
  walks.checked = method.walks_public ?? false;
  const walksBox = make('p', {}, make('label', { class: 'row' }, walks,
    'Everybody may see the trajectories of this submission, and how each is scored'));
  const box = make('details', { class: 'new' }, make('summary', {}, make('h3', {}, 'Describe this method')),
    form('Save', [textBox, paperBox, codeBox, bibtexBox, weightsBox, ...(openGoals ? [walksBox] : [])], async () => {
      const said = {
        description: text.value.trim(), bibtex: bibtex.value.trim(), paper: paper.value.trim(), code: code.value.trim(),
        weights: weights.value, walks_public: openGoals && walks.checked,
      };
      saved(await api.call<Method>(`submissions/${method.id}/method`, json(said, 'PUT')));
      box.open = false;
      toast('The description is saved.');
    }));
  return box;
}
