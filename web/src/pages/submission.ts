/** The page of a submission's method: `/submission?id=3`. */
import type { Who } from '../elements/forms.ts';
import { addSiteHeader, byId, crumbs, dateTime, empty, facts, loading, make, problems, run, table } from '../elements/page.ts';
import { episodePage, splitKey } from '../episodes/splits.ts';
import { comparisonBox } from '../evaluation/comparison.ts';
import { aboutMethod, type Method, methodForm, withheldTexts } from '../evaluation/method.ts';
import { ownTeam } from '../evaluation/own_team.ts';
import { benchmarkOf, type Phase, type PhaseList, primaryOf } from '../evaluation/phases.ts';
import { type Column, format, type Mean, places, rangeText, type Row, unitOf, valueOf } from '../evaluation/ranking.ts';
import { columnHead, scoreCells } from '../evaluation/scores.ts';
import { type SubmittedEpisode, worstList } from '../evaluation/worst.ts';
import { api } from '../server/api.ts';
import '../evaluation/evaluation.css';

type Means = Readonly<Record<string, Mean>>;
interface Part {
  readonly episodes: number;
  /** Paths, from which the bootstrap draws. */
  readonly groups: number;
  readonly means: Means;
}
interface Breakdown {
  readonly buildings: readonly (Part & { readonly scan: string })[];
  /** By the length of the reference path, metres. */
  readonly lengths: readonly (Part & { readonly least: number; readonly most: number })[];
  readonly worst?: readonly SubmittedEpisode[];
}

const main = byId('main');

/** Columns of the parts' tables: what ranks, and what comes next. */
const shownColumns = 5;

function scoresTable(means: Means, columns: readonly Column[]): HTMLElement {
  const rows = columns.filter(({ name }) => means[name]).map((column) => [column.title,
    make('td', { class: 'number', 'data-label': unitOf(column) }, `${format(valueOf({ means }, column), column)} ${unitOf(column)}`),
    make('td', { class: 'number', 'data-label': '95 % interval' }, rangeText({ means }, column) || '–')]);
  return table(['Measure', 'Mean', make('th', { scope: 'col', class: 'number' }, '95 % interval')], rows, { label: 'Scores' });
}

function partsTable(title: string, parts: readonly Part[], names: readonly (string | Node)[], columns: readonly Column[]): HTMLElement {
  const shown = columns.slice(0, shownColumns);
  const cells = shown.map((column) => scoreCells(parts, column));
  const count = (part: Part) => make('td', { class: 'number', 'data-label': 'Episodes' }, part.episodes.toLocaleString('en-US'));
  const rows = parts.map((part, k) => [make('td', { class: 'wide' }, names[k]!), count(part), ...cells.map((list) => list[k]!)]);
  return table([title, make('th', { scope: 'col', class: 'number' }, 'Episodes'), ...shown.map(columnHead)], rows,
    { kind: 'stack', label: `Results by ${title.toLowerCase()}` });
}

async function showParts(box: HTMLElement, method: Method, phase: Phase): Promise<void> {
  const { buildings, lengths, worst } = await api.call<Breakdown>(`submissions/${method.id}/breakdown`);
  const number = (value: number) => value.toLocaleString('en-US');
  const links = buildings.map(({ scan }) => make('a', { href: `/view#${encodeURIComponent(scan)}` }, scan));
  const lengthNames = lengths.map(({ least, most }) => `${number(least)} to ${number(most)} m`);
  const hidden = make('p', { class: 'note' }, 'Only your team and the organisers see these, until you show the trajectories to everybody.');
  box.replaceChildren(
    make('h2', {}, 'By building'), partsTable('Building', buildings, links, phase.columns),
    make('h2', {}, 'By path length'), partsTable('Path length', lengths, lengthNames, phase.columns),
    ...(worst ? [make('h2', {}, 'Worst episodes'), ...(method.walks_public ? [] : [hidden]),
      worstList(worst, phase, (episode) => episodePage(splitKey(phase), episode, { submission: String(method.id) }))] : []));
}

/** Rank, phase, date: what is known beside the scores. @param board each team's best */
function factsOf(method: Method, phase: Phase | undefined, board: readonly Row[]): HTMLElement {
  const at = board.findIndex(({ id }) => id === method.id);
  const rank = phase && at >= 0 ? places(board, primaryOf(phase))[at]! : undefined;
  return facts([
    ...(phase && rank !== undefined ? [['Rank', make('a', {
      href: `/leaderboard?${new URLSearchParams({ phase: phase.phase })}#submission-${method.id}` }, `${rank} of ${board.length}`)] as const] : []),
    ['Team', method.team], ...(phase ? [['Benchmark', benchmarkOf(phase)] as const, ['Split', phase.split] as const] : []),
    ['Submitted, UTC', dateTime(method.created)], ['Weights', method.weights ?? 'not said'],
    ['Trajectories', method.walks_public ? 'shown to everybody' : 'not shown']]);
}

function showMethod(method: Method, phase: Phase | undefined, board: readonly Row[], team: string | undefined): void {
  const yours = method.team === team ? [' ', make('span', { class: 'badge good' }, 'yours')] : [];
  const saved = (changed: Method): void => {
    if (changed.walks_public !== method.walks_public) location.reload(); // other episodes are to be seen
    head.replaceChildren(...parts(changed));
  };
  const parts = (one: Method): (Node | string)[] => [make('h1', {}, one.method, ...yours), factsOf(one, phase, board), ...aboutMethod(one),
    ...(one.own ? [methodForm(one, phase !== undefined && !phase.goals_secret, saved)] : [])];
  const head = make('div', {}, ...parts(method));
  main.append(head, make('h2', {}, 'Scores'));
  if (method.means && phase) main.append(scoresTable(method.means, phase.columns));
  else main.append(make('p', {}, method.withheld ? `${withheldTexts[method.withheld]}.` : `This submission is ${method.state}.`));
}

run(async () => {
  await addSiteHeader();
  const id = Number(new URLSearchParams(location.search).get('id'));
  if (!Number.isSafeInteger(id) || id < 1) throw new Error('The address names no submission: /submission?id=NUMBER');
  const [method, { phases }, who] = await Promise.all([
    api.call<Method>(`submissions/${id}/method`), api.call<PhaseList>('phases'), api.call<Who>('session')]);
  const phase = phases.find((one) => one.phase === method.phase);
  document.title = `${method.method}, ${method.team} · Enfilade`;
  const rowsOf = async (all: boolean): Promise<readonly Row[]> => (!phase || !method.means ? []
    : (await api.call<{ rows: Row[] }>(`leaderboards/${encodeURIComponent(phase.phase)}${all ? '?all=1' : ''}`)).rows);
  const [board, all] = await Promise.all([rowsOf(false), method.broken_down ? rowsOf(true) : undefined]);
  main.append(crumbs([['/leaderboard', 'Leaderboard'],
    ...(phase ? [[`/leaderboard?${new URLSearchParams({ phase: phase.phase })}`, phase.title] as const] : [])], method.method));
  showMethod(method, phase, board, ownTeam(who));
  if (!phase) {
    main.append(empty('Its phase is no longer here', `The organisers have removed the phase ${method.phase}.`));
    return;
  }
  if (method.broken_down) {
    const box = make('section', { 'aria-live': 'polite' }, loading());
    main.append(box);
    showParts(box, method, phase).catch((error: unknown) => box.replaceChildren(problems(error)));
  } else if (phase.goals_secret) {
    main.append(make('p', { class: 'note' }, 'The goals of this split are secret, so there are no scores by building or episode.'));
  }
  const rows = all ?? board;
  if (rows.some((row) => row.id === method.id)) main.append(...comparisonBox(phase, rows, method.id));
}, 'This submission cannot be shown', '/leaderboard');
