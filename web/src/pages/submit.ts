/** Making a team, logging in, submitting, and a team's history. */
import { jsonFiles } from '../elements/files.ts';
import { action, field, form, labelled, loggedIn, loginForm, twice, type Who } from '../elements/forms.ts';
import { linkCopier } from '../elements/link_copier.ts';
import { addSiteHeader, byId, counted, dateTime, empty, make, problems, run, table } from '../elements/page.ts';
import { methodLink, type Submission, withheldTexts } from '../evaluation/method.ts';
import { rememberTeam } from '../evaluation/own_team.ts';
import {
  benchmarkOf, endOf, inOrder, leakageNote, limitsOf, type Phase, type PhaseList, primaryOf, showingOf,
} from '../evaluation/phases.ts';
import { type Column, format, places, type Row, unitOf, valueOf } from '../evaluation/ranking.ts';
import { columnHead } from '../evaluation/scores.ts';
import { api, json, ServerError } from '../server/api.ts';
import '../evaluation/evaluation.css';

const main = byId('main');

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
      const { button, said } = linkCopier('Copy', 'Token', () => team.token, 'Token copied');
      made.replaceChildren(
        make('p', { class: 'done', role: 'status' }, 'The team is created. This is its token; it is shown only once, so keep it:'),
        make('div', { class: 'token-row' }, make('p', { class: 'token' }, team.token), button, said));
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
  return table(
    ['No.', ...(role === 'organiser' ? ['Team'] : []), 'Method', 'State', ...columns.map(columnHead), 'Phase', 'Submitted', ''],
    list.map((s) => {
      const withdraw = twice(`Withdraw ${s.id}`, `Withdraw ${s.id} for good?`, said, async () => {
        await api.call(`submissions/${s.id}`, { method: 'DELETE' });
        await changed();
      });
      withdraw.disabled = s.state === 'withdrawn';
      return [make('td', { class: 'rank' }, String(s.id)), ...(role === 'organiser' ? [make('td', { class: 'rest' }, s.team)] : []),
        make('td', { class: 'rest' }, make('a', { href: methodLink(s.id) }, s.method)),
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

/** A file that was sent to the wrong phase, and the button that sends it to the right one. @param said what goes wrong is shown there */
function otherSplit(sent: Phase, right: Phase, said: HTMLElement, send: () => Promise<void>): HTMLElement {
  return make('div', { class: 'notice', role: 'alert' },
    make('p', {}, `This is a file of ${right.split}, not of ${sent.split}. Nothing was submitted.`),
    make('p', { class: 'buttons' }, action(`Submit it to ${right.title}`, said, send)));
}

const scoringMs = 500;

/** Asks until the submission is scored, or nothing more of it will be told. */
async function whenScored(id: number): Promise<Submission> {
  for (;;) {
    const one = await api.call<Submission>(`submissions/${id}`);
    if (one.state !== 'queued') return one;
    await new Promise((resolve) => setTimeout(resolve, scoringMs));
  }
}

/** Where a submission stands on the leaderboard, and what its team can do next. */
async function standingOf(taken: Submission, phase: Phase): Promise<HTMLElement> {
  const { id, means, withheld, state } = await whenScored(taken.id);
  const board = (hash: string) => `/leaderboard?${new URLSearchParams({ phase: phase.phase })}${hash}`;
  const describe = make('a', { href: methodLink(id), class: 'button' }, 'Describe the method');
  const row = (href: string, text: string) => make('p', { class: 'buttons' }, make('a', { href, class: 'button' }, text), describe);
  if (!means) {
    const why = withheld ? `${withheldTexts[withheld]}.` : `Submission ${id} is ${state}.`;
    return make('div', {}, make('p', {}, why), row(board(''), `See ${phase.title}`));
  }
  const { rows } = await api.call<{ rows: Row[] }>(`leaderboards/${encodeURIComponent(phase.phase)}`);
  const at = rows.findIndex((one) => one.id === id);
  if (at >= 0) return row(board(`#submission-${id}`), `Rank ${places(rows, primaryOf(phase))[at]!} of ${rows.length}: see the row`);
  const best = rows.find(({ team }) => team === taken.team);
  return make('div', {}, make('p', {}, `Your team's best stays ${best ? `submission ${best.id}` : 'another one'}.`),
    row(board(best ? `#submission-${best.id}` : ''), `See the row of ${best ? `submission ${best.id}` : 'your team'}`));
}

async function showTeam(who: Who): Promise<void> {
  const phases = inOrder((await api.call<PhaseList>('phases')).phases);
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
  const standing = make('div', { 'aria-live': 'polite' });
  /** Hands the chosen file in; one of another split can be sent there by a button. */
  const send = async (): Promise<void> => {
    said.replaceChildren();
    standing.replaceChildren();
    const chosen = phases.find((p) => p.phase === phase.value)!;
    const query = new URLSearchParams({ phase: chosen.phase, method: method.value.trim() });
    for (const link of [paper, code]) if (link.value) query.set(link.id, link.value.trim());
    try {
      const taken = await api.call<Submission>(`submissions?${query}`, { method: 'POST', body: file.files![0]! });
      rememberTeam(taken.team);
      said.replaceChildren(make('p', { class: 'done' }, `The file is valid: submission ${taken.id}.`),
        ...(taken.warnings ?? []).map((text) => make('p', { class: 'note' }, text)));
      standingOf(taken, chosen).then((found) => standing.replaceChildren(found), (error: unknown) => standing.replaceChildren(problems(error)));
    } catch (error) {
      const right = error instanceof ServerError ? phases.find((p) => p.phase === error.phase) : undefined;
      if (!right) throw error;
      said.replaceChildren(otherSplit(chosen, right, said, () => {
        phase.value = right.phase;
        showRules();
        return send();
      }));
      return;
    }
    await refresh();
  };
  main.append(loggedIn(who));
  if (who.role === 'team') {
    main.append(form('Check and submit', [phaseField, rules, methodField, paperField, codeField, fileField], send));
  }
  main.append(said, standing, heading, history);
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
