/** Teams of the evaluation, for organisers: who may submit where goals are secret. */
import { action, field, form } from '../elements/forms.ts';
import { dateTime, make, table } from '../elements/page.ts';
import { api, json } from '../server/api.ts';

interface Team {
  readonly id: number;
  readonly name: string;
  readonly contact: string;
  readonly created: string;
  readonly approved: boolean;
  readonly submissions: number;
}

/** A list with buttons, and a form that makes a team. */
export async function teamsBox(): Promise<HTMLElement> {
  const said = make('div', { 'aria-live': 'polite' });
  const list = make('div');
  const heading = make('h2', { tabindex: '-1' }, 'Teams');
  const rowOf = (team: Team) => {
    const text = team.approved ? 'Withdraw approval' : 'Approve';
    const button = action(text, said, async () => {
      await api.call(`teams/${team.id}/approval`, json({ approved: !team.approved }, 'PUT'));
      await refresh();
      heading.focus(); // the button that was pressed is gone
    }, { 'aria-label': `${text}: ${team.name}` });
    return [team.name, team.contact, make('td', { class: 'number' }, String(team.submissions)), make('td', { class: 'date' }, dateTime(team.created)),
      team.approved ? 'yes' : 'no', button];
  };
  const refresh = async (): Promise<void> => {
    const { teams } = await api.call<{ teams: Team[] }>('teams');
    list.replaceChildren(teams.length === 0 ? make('p', {}, 'No teams yet.')
      : table(['Team', 'Contact', 'Submissions', 'Created', 'Approved', ''], teams.map(rowOf)));
  };
  const [nameField, name] = field('team-name', 'Name, as the leaderboard shows it', { maxlength: '80' });
  const [contactField, contact] = field('team-contact', 'Contact', { maxlength: '200' });
  contact.required = false;
  const made = form('Create team', [nameField, contactField], async () => {
    const team = await api.call<{ token: string }>('teams', json({ name: name.value.trim(), contact: contact.value.trim() }));
    said.replaceChildren(
      make('p', { class: 'done' }, 'The team is created and approved. Send it this token; it is shown only once:'),
      make('p', { class: 'token' }, team.token));
    await refresh();
  });
  await refresh();
  return make('section', {}, heading,
    make('p', { class: 'note' }, 'A team submits to phases with secret goals once you have approved it. Approve people whom you know: each team learns a little of the goals.'),
    said, list, make('details', { class: 'new' }, make('summary', {}, make('h3', {}, 'New team')), made));
}
