/** Making a team, logging in, handing in, and a team's history. */
import { field, form, loggedIn, loginForm, twice, type Who } from '../forms.ts';
import { addSiteHeader, api, byId, dateTime, json, make, problems, run, table } from '../page.ts';

interface Phase { readonly phase: string; readonly title: string; readonly per_day: number }
interface Submission {
  readonly id: number;
  readonly team: string;
  readonly phase: string;
  readonly method: string;
  readonly state: string;
  readonly created: string;
  readonly means?: Readonly<Record<string, { mean: number | null }>>;
  readonly warnings?: readonly string[];
}

const main = byId('main');

function showStranger(): void {
  const login = loginForm("Your team's token");
  const [nameField, name] = field('name', "The team's name, as the leaderboard shows it", { maxlength: '80' });
  const made = make('div');
  main.append(
    make('h2', {}, 'Log in'),
    login,
    make('h2', {}, 'Or make a team'),
    form('Make the team', [nameField], async () => {
      const team = await api.call<{ token: string }>('teams', json({ name: name.value.trim() }));
      made.replaceChildren(
        make('p', { class: 'done', role: 'status' }, 'The team is made. This is its token; it is shown this once, keep it:'),
        make('p', { class: 'token' }, team.token));
      login.querySelector('input')!.value = team.token;
    }),
    made);
}

function historyTable(list: readonly Submission[], role: Who['role'], said: HTMLElement, changed: () => Promise<void>): HTMLElement {
  const show = (s: Submission, name: string, unit: number) => {
    const mean = s.means?.[name]?.mean;
    return make('td', { class: 'number' }, mean === undefined || mean === null ? '–' : (mean * unit).toFixed(unit === 1 ? 2 : 1));
  };
  return table(
    ['No.', ...(role === 'organiser' ? ['Team'] : []), 'Method', 'State', 'NE', 'SR', 'SPL', 'Phase', 'Handed in', ''],
    list.map((s) => {
      const withdraw = twice(`Withdraw ${s.id}`, `Withdraw ${s.id} for good?`, said, async () => {
        await api.call(`submissions/${s.id}`, { method: 'DELETE' });
        await changed();
      });
      withdraw.disabled = s.state === 'withdrawn';
      return [String(s.id), ...(role === 'organiser' ? [s.team] : []), s.method, s.state, show(s, 'nav_error', 1), show(s, 'success', 100),
        show(s, 'spl', 100), s.phase, make('td', { class: 'date' }, dateTime(s.created)), withdraw];
    }),
  );
}

async function showTeam(who: Who): Promise<void> {
  const { phases } = await api.call<{ phases: Phase[] }>('phases');
  const phase = make('select', { id: 'phase' }, ...phases.map((p) => new Option(`${p.title} (${p.per_day} a day)`, p.phase)));
  const [methodField, method] = field('method', 'Method, as the leaderboard shows it', { maxlength: '80' });
  const [fileField, file] = field('file', 'Results file (JSON)', { type: 'file', accept: '.json,application/json' });
  const said = make('div', { 'aria-live': 'polite' });
  const heading = make('h2', { tabindex: '-1' }, who.role === 'team' ? 'What you handed in' : 'All submissions');
  const history = make('div', { 'aria-live': 'polite' });
  const refresh = async (): Promise<void> => {
    const { submissions } = await api.call<{ submissions: Submission[] }>('submissions');
    history.replaceChildren(submissions.length === 0 ? make('p', {}, 'None yet.') : historyTable(submissions, who.role, said, async () => {
      await refresh();
      heading.focus(); // the button that was pressed is gone
    }));
    if (submissions.some(({ state }) => state === 'queued')) {
      setTimeout(() => { refresh().catch((error: unknown) => said.replaceChildren(problems(error))); }, 1000);
    }
  };
  main.append(loggedIn(who));
  if (who.role === 'team') {
    main.append(form('Check and hand in', [make('label', { for: 'phase' }, 'Phase'), phase, methodField, fileField], async () => {
      said.replaceChildren();
      const query = new URLSearchParams({ phase: phase.value, method: method.value.trim() });
      const taken = await api.call<Submission>(`submissions?${query}`, { method: 'POST', body: file.files![0]! });
      said.replaceChildren(make('p', { class: 'done' }, `The file is good: submission ${taken.id}.`),
        ...(taken.warnings ?? []).map((text) => make('p', { class: 'note' }, text)));
      await refresh();
    }));
  }
  main.append(said, heading, history);
  await refresh();
}

run(async () => {
  await addSiteHeader();
  main.append(make('h1', {}, 'Submit'));
  const who = await api.call<Who>('session');
  if (who.role === 'stranger') showStranger();
  else if (who.role === 'reviewer') main.append(loggedIn(who), make('p', {}, make('a', { href: '/organise' }, 'To what is to be reviewed')));
  else await showTeam(who);
});
