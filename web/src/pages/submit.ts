/** Making a team, logging in, handing in, and a team's history. */
import { addHeader, api, byId, make, problems, run, table } from '../page.ts';

interface Phase { readonly phase: string; readonly title: string; readonly per_day: number }
interface Who { readonly role: 'stranger' | 'team' | 'organiser'; readonly name?: string }
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
const json = (body: unknown): RequestInit => ({
  method: 'POST', body: JSON.stringify(body), headers: { 'Content-Type': 'application/json' },
});

/** A form whose button waits for what it started, and shows what went wrong below it. */
function form(text: string, fields: readonly HTMLElement[], send: () => Promise<void>): HTMLElement {
  const button = make('button', { class: 'main' }, text);
  const said = make('div');
  const element = make('form', {}, ...fields, make('p', {}, button), said);
  element.addEventListener('submit', (event) => {
    event.preventDefault();
    button.disabled = true;
    said.replaceChildren();
    send().catch((error: unknown) => said.replaceChildren(problems(error)))
      .finally(() => { button.disabled = false; });
  });
  return element;
}

function field(id: string, text: string, attributes: Record<string, string> = {}): [HTMLElement, HTMLInputElement] {
  const input = make('input', { id, type: 'text', required: '', ...attributes });
  return [make('div', {}, make('label', { for: id }, text), input), input];
}

function showStranger(): void {
  const [tokenField, token] = field('token', "Your team's token", { type: 'password', autocomplete: 'off' });
  const [nameField, name] = field('name', "The team's name, as the leaderboard shows it", { maxlength: '80' });
  const made = make('div');
  main.append(
    make('h2', {}, 'Log in'),
    form('Log in', [tokenField], async () => {
      await api.call('session', json({ token: token.value.trim() }));
      location.reload();
    }),
    make('h2', {}, 'Or make a team'),
    form('Make the team', [nameField], async () => {
      const team = await api.call<{ token: string }>('teams', json({ name: name.value.trim() }));
      made.replaceChildren(
        make('p', { class: 'done', role: 'status' }, 'The team is made. This is its token; it is shown this once, keep it:'),
        make('p', { class: 'token' }, team.token));
      token.value = team.token;
    }),
    made);
}

function historyTable(list: readonly Submission[], changed: () => void): HTMLElement {
  const show = (s: Submission, name: string, unit: number) => {
    const mean = s.means?.[name]?.mean;
    return make('td', { class: 'number' }, mean === undefined || mean === null ? '–' : (mean * unit).toFixed(unit === 1 ? 2 : 1));
  };
  return table(
    ['No.', 'Phase', 'Method', 'Handed in', 'State', 'NE', 'SR', 'SPL', ''],
    list.map((s) => {
      const withdraw = make('button', { type: 'button', 'aria-label': `Withdraw submission ${s.id}` }, 'Withdraw');
      withdraw.disabled = s.state === 'withdrawn';
      withdraw.addEventListener('click', () => {
        if (!confirm(`Withdraw submission ${s.id} from the leaderboard, for good?`)) return;
        api.call(`submissions/${s.id}`, { method: 'DELETE' }).then(changed, (e: unknown) => main.append(problems(e)));
      });
      return [String(s.id), s.phase, s.method, s.created.slice(0, 16).replace('T', ' '), s.state,
        show(s, 'nav_error', 1), show(s, 'success', 100), show(s, 'spl', 100), withdraw];
    }),
  );
}

async function showTeam(who: Who): Promise<void> {
  const { phases } = await api.call<{ phases: Phase[] }>('phases');
  const phase = make('select', { id: 'phase' }, ...phases.map((p) => new Option(`${p.title} (${p.per_day} a day)`, p.phase)));
  const [methodField, method] = field('method', 'Method, as the leaderboard shows it', { maxlength: '80' });
  const [fileField, file] = field('file', 'Results file (JSON)', { type: 'file', accept: '.json,application/json' });
  const said = make('div', { 'aria-live': 'polite' });
  const history = make('div', { 'aria-live': 'polite' });
  const refresh = async (): Promise<void> => {
    const { submissions } = await api.call<{ submissions: Submission[] }>('submissions');
    history.replaceChildren(submissions.length === 0 ? make('p', {}, 'None yet.') : historyTable(submissions, () => void refresh()));
    if (submissions.some(({ state }) => state === 'queued')) setTimeout(() => void refresh(), 1000);
  };
  const logOut = make('button', { type: 'button' }, 'Log out');
  logOut.addEventListener('click', () => void api.call('session', { method: 'DELETE' }).then(() => location.reload()));
  main.append(make('p', {}, 'You are ', make('strong', {}, who.name ?? ''), '. ', logOut));
  if (who.role === 'team') {
    main.append(form('Check and hand in', [make('label', { for: 'phase' }, 'Phase'), phase, methodField, fileField], async () => {
      said.replaceChildren();
      const query = new URLSearchParams({ phase: phase.value, method: method.value.trim() });
      const taken = await api.call<Submission>(`submissions?${query}`, { method: 'POST', body: file.files![0]! });
      said.replaceChildren(make('p', { class: 'done' }, `The file is good: submission ${taken.id}.`),
        ...(taken.warnings ?? []).map((text) => make('p', { class: 'note' }, text)));
      await refresh();
    }), said);
  }
  main.append(make('h2', {}, who.role === 'team' ? 'What you handed in' : 'All submissions'), history);
  await refresh();
}

run(async () => {
  const { synthetic } = await api.call<{ synthetic: boolean }>('scans');
  addHeader(synthetic);
  main.append(make('h1', {}, 'Submit'));
  const who = await api.call<Who>('session');
  if (who.role === 'stranger') showStranger();
  else await showTeam(who);
});
