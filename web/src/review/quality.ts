/** How a study goes: its days, how far its workers agree, how they answered questions with known answers. */
import { addressOf, reviewPage } from '../collecting/addresses.ts';
import type { Agreement, Collection, QuestionResult } from '../collecting/collections.ts';
import { dayChart } from '../elements/day_chart.ts';
import { counted, facts, make, table } from '../elements/page.ts';
import { api } from '../server/api.ts';

const numbers = (text: string): HTMLElement => make('th', { scope: 'col', class: 'number' }, text);
const share = (value: number): string => `${(100 * value).toFixed(0)} %`;
const measures: Readonly<Record<Agreement['measure'], string>> = {
  'token-f1': 'F1 of the tokens of two texts of the same path, each token as often as both have it; 1.00 where both have the same words. ' +
    'Mean over all pairs of a path, then over paths. Rejected texts are left out.',
  'same-outcome': 'Whether two workers with the same instruction or goal both reached it, or neither did. ' +
    'Mean over all pairs of an instruction, then over instructions. Rejected work is left out.',
};

/** The numbers of an agreement, with their names. */
export function numbersOf({ measure, items, pairs, mean, others, success, metres }: Agreement): [string, string][] {
  const texts = measure === 'token-f1';
  const number = (value: number) => (texts ? value.toFixed(2) : share(value));
  return [
    ...(mean === null ? [] : [[texts ? 'Token F1 of texts of a path' : 'Pairs with the same outcome', number(mean)] as [string, string]]),
    ...(typeof others === 'number' ? [['Token F1 of texts of two paths', others.toFixed(2)] as [string, string]] : []),
    ...(typeof success === 'number' ? [['Success rate', share(success)] as [string, string]] : []),
    ...(typeof metres === 'number' ? [['Mean difference of the distance to the goal', `${metres.toFixed(1)} m`] as [string, string]] : []),
    ['Compared', `${counted(pairs, 'pair')} of ${counted(items, 'item')}`],
  ];
}

function agreementPart(collection: string, agreement: Agreement): HTMLElement[] {
  const texts = agreement.measure === 'token-f1';
  if (agreement.items === 0) return [make('p', {}, 'No two workers have done the same yet, or only with secret goals.')];
  const link = (path: number) => make('a', { href: reviewPage(collection, { state: 'all', path: String(path) }) }, `Path ${path}`);
  return [facts(numbersOf(agreement)), make('p', { class: 'note' }, measures[agreement.measure]), make('h3', {}, 'Where they agree least'),
    table(['Path', numbers('Tasks'), numbers(texts ? 'Token F1' : 'Same outcome')],
      agreement.least.map(({ path_id, tasks, value }) => [link(path_id), make('td', { class: 'number' }, String(tasks)),
        make('td', { class: 'number' }, texts ? value.toFixed(2) : share(value))]), { label: 'Where workers agree least' })];
}

function questionsPart(questions: readonly QuestionResult[]): HTMLElement[] {
  if (questions.length === 0) return [make('p', {}, 'This collection asks no questions.')];
  const number = (text: string) => make('td', { class: 'number' }, text);
  const choices = ({ choices: list = [] }: QuestionResult) =>
    list.map(({ choice, chosen, right }) => `${right ? '✓ ' : ''}${choice}: ${chosen}`).join(' · ');
  const told = questions.some(({ choices: list }) => list !== undefined);
  return [table(['Question', 'Asked', numbers('Answered'), numbers('Right'), ...(told ? ['Answers'] : [])],
    questions.map((one) => [one.text, one.stage === 'screening' ? 'after the consent' : 'between tasks', number(String(one.answered)),
      number(one.answered > 0 ? share(one.right / one.answered) : '–'), ...(told ? [choices(one)] : [])]), { label: 'Questions' })];
}

export async function showQuality(main: HTMLElement, { collection, progress }: Collection): Promise<void> {
  const { agreement, questions } = await api.call<{ agreement: Agreement; questions: QuestionResult[] }>(`${addressOf(collection)}/quality`);
  const days = dayChart(progress?.days ?? []);
  main.append(make('h2', {}, 'Progress'), ...(days.length > 0 ? days : [make('p', {}, 'Nothing is submitted yet.')]),
    make('h2', {}, 'Agreement between workers'), ...agreementPart(collection, agreement),
    make('h2', {}, 'Questions with known answers'), ...questionsPart(questions));
}
