/** Making a team, logging in, submitting, and a team's history. */
import { jsonFiles } from '../elements/files.ts';
import { field, form, labelled, loggedIn, loginForm, twice, type Who } from '../elements/forms.ts';
import { addSiteHeader, byId, counted, dateTime, empty, make, problems, run, table } from '../elements/page.ts';
import {
  benchmarkOf, endOf, leakageNote, limitsOf, type Phase, type PhaseList, showingOf,
} from '../evaluation/phases.ts';
import { type Column, format, type Mean, unitOf, valueOf } from '../evaluation/ranking.ts';
import { api, json } from '../server/api.ts';

interface Submission {
  readonly id: number;
  readonly team: string;
  readonly phase: string;
  readonly method: string;
  readonly state: string;
  readonly created: string;
  readonly means?: Readonly<Record<string, Mean>>;
  readonly withheld?: 'until-end' | 'no-improvement' | 'not-best' | 'hidden' | 'other-scorer';
  readonly near_copy?: { readonly of: number; readonly differing: number };
  readonly warnings?: readonly string[];
}

const main = byId('main');

/** Why a submission has no scores. */
const withheldTexts: Record<NonNullable<Submission['withheld']>, string> = {
  'until-end': 'Scores appear when the phase has ended',
  'no-improvement': "Not a step better than your team's best",
  'not-best': 'Another submission stands for your team',
  hidden: 'Only the organisers see its scores',
  'other-scorer': 'Scored before the phase was changed, by another scorer',
};

function stateOf({ state, withheld, near_copy }: Submission): HTMLElement {
  const badge = { scored: ' good', failed: ' bad', queued: ' wait' }[state] ?? '';
  const cell = make('td', { class: 'wide', 'data-label': 'State' }, make('span', { class: `badge${badge}` }, state));
  if (withheld) cell.append(make('span', { class: 'note' }, ` ${withheldTexts[withheld]}`));
  if (near_copy) {
    cell.append(make('span', { class: 'note' }, near_copy.differing === 0
      ? ` Ends as submission ${near_copy.of}` : ` Ends as submission ${near_copy.of}, except in ${counted(near_copy.differing, 'episode')}`));
  }
  return cell;
}

async function showStranger(): Promise<void> {
  const login = loginForm("Your team's token");
  const { registration } = await api.call<PhaseList>('phases');
  if (registration === 'closed') {
    main.append(make('h2', {}, 'Log in'), login,
      make('p', {}, 'Registration is closed here: the organisers make teams, and give them their tokens.'));
    return;
  }
  const [nameField, name] = field('name', "The team's name, as the leaderboard shows it", { maxlength: '80' });
  const made = make('div');
  main.append(
    make('h2', {}, 'Log in'),
    login,
    make('h2', {}, 'Or create a team'),
    form('Create team', [nameField], async () => {
      const team = await api.call<{ token: string }>('teams', json({ name: name.value.trim() }));
      made.replaceChildren(
        make('p', { class: 'done', role: 'status' }, 'The team is created. This is its token; it is shown only once, so keep it:'),
        make('p', { class: 'token' }, team.token));
      login.querySelector('input')!.value = team.token;
    }),
    made);
}

/** How many of a phase's columns a history shows: what ranks, and what comes next. */
const shownColumns = 3;

/** Submissions whose phases have the same columns. */
function historyTable(list: readonly Submission[], columns: readonly Column[], label: string, role: Who['role'], said: HTMLElement, changed: () => Promise<void>): HTMLElement {
  const show = ({ means }: Submission, column: Column) => make('td', { class: 'number', 'data-label': `${column.short}, ${unitOf(column)}` },
    format(means && valueOf({ means }, column), column));
  const head = (column: Column) => make('th', { scope: 'col', class: 'number', title: column.title }, column.short, make('span', { class: 'unit' }, unitOf(column)));
  return table(
    ['No.', ...(role === 'organiser' ? ['Team'] : []), 'Method', 'State', ...columns.map(head), 'Phase', 'Submitted', ''],
    list.map((s) => {
      const withdraw = twice(`Withdraw ${s.id}`, `Withdraw ${s.id} for good?`, said, async () => {
        await api.call(`submissions/${s.id}`, { method: 'DELETE' });
        await changed();
      });
      withdraw.disabled = s.state === 'withdrawn';
      return [make('td', { class: 'rank' }, String(s.id)), ...(role === 'organiser' ? [make('td', { class: 'rest' }, s.team)] : []), make('td', { class: 'rest' }, s.method),
        stateOf(s), ...columns.map((column) => show(s, column)),
        make('td', { class: 'half', 'data-label': 'Phase' }, s.phase), make('td', { class: 'date half', 'data-label': 'Submitted, UTC' }, dateTime(s.created)),
        make('td', { class: 'wide' }, withdraw)];
    }),
    { kind: 'stack', label },
  );
}

/** A table for each benchmark, as each has columns of its own; with headings where there are several. */
function histories(list: readonly Submission[], phases: readonly Phase[], role: Who['role'], said: HTMLElement, changed: () => Promise<void>): HTMLElement[] {
  const groups = new Map<string, { columns: readonly Column[]; list: Submission[] }>();
  for (const one of list) {
    const phase = phases.find((p) => p.phase === one.phase);
    const name = phase ? benchmarkOf(phase) : 'Phases that are no longer here';
    const group = groups.get(name) ?? { columns: phase?.columns.slice(0, shownColumns) ?? [], list: [] };
    group.list.push(one);
    groups.set(name, group);
  }
  return [...groups].flatMap(([name, group]) => [
    ...(groups.size > 1 ? [make('h3', {}, name)] : []),
    historyTable(group.list, group.columns, groups.size > 1 ? `Submissions to ${name}` : 'Submissions', role, said, changed)]);
}

async function showTeam(who: Who): Promise<void> {
  const { phases } = await api.call<PhaseList>('phases');
  const [phaseField, phase] = labelled('phase', 'Phase', make('select', {}, ...phases.map((p) => new Option(`${p.title} (${limitsOf(p)})`, p.phase))));
  const rules = make('div', { 'aria-live': 'polite' });
  const showRules = () => {
    const chosen = phases.find((p) => p.phase === phase.value);
    if (!chosen) return;
    const texts = [`${benchmarkOf(chosen)}.`, showingOf(chosen), endOf(chosen)].filter((text) => text !== '');
    rules.replaceChildren(...texts.map((text) => make('p', { class: 'note' }, text)), ...leakageNote(chosen));
    if (chosen.goals_secret && who.approved === false) {
      rules.append(make('p', { class: 'problem' }, 'Your team is not approved for this phase yet. Ask the organisers.'));
    }
  };
  const wanted = new URLSearchParams(location.search).get('phase');
  if (phases.some((p) => p.phase === wanted)) phase.value = wanted!;
  phase.addEventListener('change', showRules);
  showRules();
  const [methodField, method] = field('method', 'Method, as the leaderboard shows it', { maxlength: '80' });
  const [paperField, paper] = field('paper', 'Paper (optional)', { type: 'url', maxlength: '300', pattern: 'https://.*', placeholder: 'https://' });
  const [codeField, code] = field('code', 'Code (optional)', { type: 'url', maxlength: '300', pattern: 'https://.*', placeholder: 'https://' });
  paper.required = code.required = false;
  const [fileField, file] = field('file', 'Results file (JSON)', { type: 'file', accept: jsonFiles });
  const said = make('div', { 'aria-live': 'polite' });
  const heading = make('h2', { tabindex: '-1' }, who.role === 'team' ? 'Your submissions' : 'All submissions');
  const history = make('div', { 'aria-live': 'polite' });
  const refresh = async (): Promise<void> => {
    const { submissions } = await api.call<{ submissions: Submission[] }>('submissions');
    history.replaceChildren(...(submissions.length === 0 ? [empty('No submissions yet', 'What you submit is listed here, with its scores.')] : histories(submissions, phases, who.role, said, async () => {
      await refresh();
      heading.focus(); // the button that was pressed is gone
    })));
    if (submissions.some(({ state }) => state === 'queued')) {
      setTimeout(() => { refresh().catch((error: unknown) => said.replaceChildren(problems(error))); }, 1000);
    }
  };
  main.append(loggedIn(who));
  if (who.role === 'team') {
    main.append(form('Check and submit', [phaseField, rules, methodField, paperField, codeField, fileField], async () => {
      said.replaceChildren();
      const query = new URLSearchParams({ phase: phase.value, method: method.value.trim() });
      for (const link of [paper, code]) if (link.value) query.set(link.id, link.value.trim());
      const taken = await api.call<Submission>(`submissions?${query}`, { method: 'POST', body: file.files![0]! });
      said.replaceChildren(make('p', { class: 'done' }, `The file is valid: submission ${taken.id}.`),
        ...(taken.warnings ?? []).map((text) => make('p', { class: 'note' }, text)));
      await refresh();
    }));
  }
  main.append(said, heading, history);
  await refresh();
}

run(async () => {
  await addSiteHeader();
  main.append(make('div', { class: 'page-head' }, make('h1', {}, 'Submit'),
    make('p', { class: 'lead' }, 'A results file is checked at once, and scored in the background. Nothing of it is published but its scores.')));
  const who = await api.call<Who>('session');
  if (who.role === 'stranger') await showStranger();
  else if (who.role === 'reviewer') main.append(loggedIn(who), make('p', {}, make('a', { href: '/organise' }, 'Go to reviews')));
  else await showTeam(who);
});
