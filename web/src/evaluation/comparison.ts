/** Two submissions of a phase compared: by a paired bootstrap where goals are open. */
import { form, labelled } from '../elements/forms.ts';
import { counted, make, table } from '../elements/page.ts';
import { api } from '../server/api.ts';
import { type Phase, primaryName } from './phases.ts';
import { type Column, factorOf, format, type Row, unitOf } from './ranking.ts';

type Value = number | null | undefined;

/** As the server answers; shares from 0 to 1. */
interface Difference {
  readonly first: Value;
  readonly second: Value;
  /** second - first. */
  readonly difference?: Value;
  readonly low?: Value;
  readonly high?: Value;
  readonly p?: number;
}
interface Comparison {
  readonly first: number;
  readonly second: number;
  /** Absent where only shown means are compared. */
  readonly episodes?: number;
  readonly groups?: number;
  readonly samples?: number;
  readonly better?: number;
  readonly worse?: number;
  readonly means: Readonly<Record<string, Difference>>;
}

const inUnit = (value: Value, column: Column): number | undefined =>
  (value === null || value === undefined ? undefined : value * factorOf(column));

/** "+1.2", "−0.3", "0.0": with the sign of what is shown. */
export function signed(value: Value, column: Column): string {
  const shown = inUnit(value, column);
  if (shown === undefined) return '–';
  const text = format(Math.abs(shown), column);
  return Number(text) === 0 ? text : `${shown > 0 ? '+' : '−'}${text}`;
}

/** "0.034"; a share of draws says no less than 2 in all of them. */
export function pText(p: number | undefined, samples: number | undefined): string {
  if (p === undefined || samples === undefined) return '–';
  const least = 2 / samples;
  return p < least ? `< ${least}` : p.toFixed(3);
}

/** Which of the two is better; nothing where neither clearly is, or where that is not known. */
export function verdictOf({ difference, p }: Difference, { better }: Column): 'first' | 'second' | undefined {
  if (p === undefined || p >= 0.05 || typeof difference !== 'number' || difference === 0 || !better) return undefined;
  return (difference > 0) === (better === 'higher') ? 'second' : 'first';
}

const number = (value: number): string => value.toLocaleString('en-US');
const nameOf = ({ id, team, method }: Row): string => `${team}: ${method} (${id})`;

function resultOf(found: Comparison, phase: Phase, first: Row, second: Row): HTMLElement {
  const { samples, groups, episodes, better, worse } = found;
  const paired = samples !== undefined;
  const label = (column: Column, text: string) => `${text}, ${unitOf(column)}`;
  const rows = phase.columns.filter(({ name }) => found.means[name]).map((column) => {
    const one = found.means[column.name]!;
    const cell = (text: string, name: string, kind = 'number') => make('td', { class: kind, 'data-label': name }, text);
    const verdict = verdictOf(one, column);
    const winner = verdict === 'second' ? second.method : first.method;
    const badge = make('span', { class: verdict === 'second' ? 'badge good' : 'badge bad' }, `${winner} is better`);
    return [
      make('td', { class: 'wide', title: column.title }, column.short, ...(verdict ? [' ', badge] : [])),
      cell(format(inUnit(one.first, column), column), label(column, 'First')),
      cell(format(inUnit(one.second, column), column), label(column, 'Second')),
      cell(signed(one.difference, column), label(column, 'Difference')),
      ...(paired ? [
        cell(`${signed(one.low, column)} to ${signed(one.high, column)}`, '95 % interval', 'number half'),
        cell(pText(one.p, samples), 'p')] : []),
    ];
  });
  const heads = ['Measure', nameOf(first), nameOf(second), 'Difference', ...(paired ? ['95 % interval', 'p'] : [])];
  const note = paired
    ? `${primaryName(phase)} is larger in ${counted(better!, 'episode')} and smaller in ${number(worse!)} of ${number(episodes!)}. `
      + `Paired bootstrap over ${counted(groups!, 'path')}, ${number(samples)} draws; `
      + 'p is two-sided, without a correction for several measures.'
    : 'The goals of this split are secret, so only the shown means are compared: there is no interval and no p.';
  return make('div', {}, table(heads, rows, { kind: 'stack', label: 'Comparison' }), make('p', { class: 'note' }, note));
}

/**
 * Two lists to choose from, and what is found; nothing for a single submission.
 * @param rows that may be compared  @param first the number of the one that stands first
 */
export function comparisonBox(phase: Phase, rows: readonly Row[], first?: number): HTMLElement[] {
  if (rows.length < 2) return [];
  const options = () => rows.map((row) => new Option(nameOf(row), String(row.id)));
  const [aBox, a] = labelled('compare-first', 'Compare', make('select', {}, ...options()));
  const [bBox, b] = labelled('compare-second', 'with', make('select', {}, ...options()));
  if (first !== undefined) a.value = String(first);
  b.value = String(rows.find(({ id }) => String(id) !== a.value)!.id);
  const found = make('div', { 'aria-live': 'polite' });
  const box = form('Compare', [make('div', { class: 'toolbar' }, aBox, bBox)], async () => {
    const of = (id: string) => rows.find((row) => String(row.id) === id)!;
    const [one, other] = [of(a.value), of(b.value)];
    const query = new URLSearchParams({ first: String(one.id), second: String(other.id) });
    const answer = await api.call<Comparison>(`leaderboards/${encodeURIComponent(phase.phase)}/comparison?${query}`);
    found.replaceChildren(resultOf(answer, phase, one, other));
  });
  return [make('h2', { id: 'compare' }, 'Compare two submissions'), box, found];
}
