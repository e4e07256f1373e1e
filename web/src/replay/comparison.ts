/** Two runs of a split: their measures with a paired test, and the episodes in which they differ. `/replay?run=A&with=B` */
import { addSiteHeader, counted, crumbs, empty, make, table } from '../elements/page.ts';
import { shownText } from '../episodes/episode.ts';
import { api } from '../server/api.ts';
import { unitText, valueText } from './columns.ts';
import { resultCell, runsPage } from './episode_table.ts';
import { address, type Broken, type Compared, type Comparison, endText, type EpisodeEnd, keyOfRun, type Run, runPath } from './runs.ts';

const perPage = 200;

/** "+4.2 (−1.0 to +9.1)", in the column's unit. */
export function differenceText({ difference: { mean, low, high }, unit }: Pick<Compared, 'difference' | 'unit'>): string {
  const signed = (value: number) => {
    const text = valueText(Math.abs(value), unit);
    return /[1-9]/.test(text) ? `${value < 0 ? '−' : '+'}${text}` : text;
  };
  return low === null || high === null ? signed(mean) : `${signed(mean)} (${signed(low)} to ${signed(high)})`;
}

/** "< 0.002", "0.04": of a thousand draws. */
export const pText = (p: number): string => (p < 0.002 ? '< 0.002' : p.toFixed(p < 0.1 ? 3 : 2));

/** Which run is better in a measure beyond chance; nothing where neither is. */
export function verdict({ difference: { mean }, better, p }: Pick<Compared, 'difference' | 'better' | 'p'>): 'first' | 'second' | undefined {
  if (!better || p >= 0.05 || mean === 0) return undefined;
  return (mean > 0) === (better === 'higher') ? 'second' : 'first';
}

const about = ({ model, prompt }: Run): string => [model, prompt && `prompt ${prompt}`].filter(Boolean).join(', ');

function measureTable({ runs: [first, second], columns }: Comparison): HTMLElement {
  const head = (run: Run) => make('th', { scope: 'col', class: 'number' },
    make('a', { href: address({ run: run.run }) }, run.run), make('span', { class: 'unit' }, about(run)));
  return table(['Measure', head(first), head(second), 'Difference (95 % interval)', 'p', 'Episodes'], columns.map((column) => {
    const better = verdict(column);
    const unit = unitText(column.unit);
    const cell = (label: string, text: string, more = '') => make('td', { class: `number ${more}`, 'data-label': label }, text);
    return [make('td', { class: 'wide', title: column.title }, make('strong', {}, column.short), unit && `, ${unit}`),
      cell(first.run, valueText(column.first, column.unit), better === 'first' ? 'half best' : 'half'),
      cell(second.run, valueText(column.second, column.unit), better === 'second' ? 'half best' : 'half'),
      cell('Difference', differenceText(column), 'wide'), cell('p', pText(column.p), 'half'),
      cell('Episodes', column.episodes.toLocaleString('en-US'), 'half')];
  }), { kind: 'stack', label: 'Measures of both runs' });
}

/** How an episode ended, in a cell. */
function endCell(end: EpisodeEnd | Broken, label: string): HTMLElement {
  if ('problem' in end) return make('td', { class: 'half problem', 'data-label': label }, end.problem);
  const cell = resultCell(end, label);
  if (end.success === undefined) cell.replaceChildren(endText(end));
  else cell.append(make('span', { class: 'method' }, endText(end)));
  return cell;
}

function differing({ runs: [first, second], list, differing: all, outcomes }: Comparison, offset: number): HTMLElement[] {
  const what = outcomes ? 'One run succeeds and the other fails' : 'The runs end at different viewpoints, or in different ways';
  if (all === 0) return [empty('No difference', `${what} in none of the episodes that both have.`)];
  const turn = (text: string, to: number) =>
    make('a', { class: 'button', href: address({ run: first.run, with: second.run, offset: String(to) }) }, text);
  const rows = list.map(({ episode, instruction, first: one, second: other }) => [
    make('td', { class: 'half' }, make('a', { href: address({ run: first.run, episode, with: second.run }) }, episode)),
    make('td', { class: 'wide replay-text' }, shownText(instruction ?? '', first.task)), endCell(one, first.run), endCell(other, second.run)]);
  return [make('p', { class: 'note' }, `${what} in ${counted(all, 'episode')}. An episode opens with both runs side by side.`),
    table(['Episode', 'Instruction', first.run, second.run], rows, { kind: 'stack', label: 'Episodes in which the runs differ' }),
    ...(all > perPage ? [make('p', { class: 'pages' }, ...(offset > 0 ? [turn('Previous', Math.max(0, offset - perPage))] : []),
      `${(offset + 1).toLocaleString('en-US')} to ${(offset + list.length).toLocaleString('en-US')} of ${all.toLocaleString('en-US')}`,
      ...(offset + perPage < all ? [turn('Next', offset + perPage)] : []))] : [])];
}

export async function compareRuns(main: HTMLElement, name: string, other: string): Promise<void> {
  await addSiteHeader();
  const offset = Math.max(0, Math.trunc(Number(new URLSearchParams(location.search).get('offset'))) || 0);
  const query = new URLSearchParams({ offset: String(offset), limit: String(perPage) });
  const found = await api.call<Comparison>(`${runPath(name)}/compare/${encodeURIComponent(other)}?${query}`);
  const [first, second] = found.runs;
  document.title = `${first.run} and ${second.run} · Enfilade`;
  const only = [[found.only_first, first], [found.only_second, second]] as const;
  const lead = [`${keyOfRun(first) ?? ''}: ${counted(found.episodes, 'episode')} that both have`,
    ...only.flatMap(([count, { run }]) => (count > 0 ? [`${counted(count, 'episode')} only in ${run}`] : []))].join(', ');
  main.append(crumbs([runsPage, [address({ run: first.run }), first.run]], `with ${second.run}`),
    make('div', { class: 'page-head' }, make('h1', {}, `${first.run} and ${second.run}`),
      make('p', { class: 'lead' }, lead)));
  if (found.episodes === 0) {
    main.append(empty('Nothing to compare', 'The two runs have no episode in common.'));
    return;
  }
  main.append(measureTable(found),
    make('p', { class: 'note' }, `The difference is ${second.run} less ${first.run}. Intervals and p come from a paired bootstrap: `,
      'it draws paths, each with all its instructions, for both runs at once. Bold: better with p < 0.05.',
      ...(found.outcomes ? [] : [' The goals of this split are hidden here, so nothing is said of success.'])),
    make('h2', {}, 'Episodes in which they differ'), ...differing(found, offset));
}
