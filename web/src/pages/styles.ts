/** Every part of style.css with its name, in all its states. In development builds only. */
import { intervalBar, progressChart } from '../elements/charts.ts';
import { dayChart } from '../elements/day_chart.ts';
import { field, form, labelled } from '../elements/forms.ts';
import { icon } from '../elements/icons.ts';
import { markdown } from '../elements/markdown.ts';
import { menu } from '../elements/menu.ts';
import { addHeader, byId, crumbs, empty, facts, loading, make, table, toast } from '../elements/page.ts';

addHeader({ synthetic: true });
const main = byId('main');

const section = (name: string, ...parts: (Node | string)[]): HTMLElement =>
  make('section', {}, make('h2', {}, name), ...parts);
const button = (text: string, name = ''): HTMLElement => make('button', { type: 'button', ...(name && { class: name }) }, text);

const sizes = ['--text-3xl', '--text-2xl', '--text-xl', '--text-l', '--text-m', '--text-s', '--text-xs'].map((name) => {
  const line = make('p', {}, `${name}: Turn left at the stairs and stop by the sofa`);
  line.style.fontSize = `var(${name})`;
  line.style.margin = '0';
  return line;
});
const spaces = [1, 2, 3, 4, 5, 6, 7, 8].map((k) => {
  const bar = make('div', {});
  bar.style.cssText = `height: 12px; width: var(--space-${k}); background: var(--accent)`;
  return [`--space-${k}`, bar] as const;
});
const colours = ['ink', 'muted', 'paper', 'raised', 'soft', 'line', 'edge', 'accent', 'accent-soft', 'good', 'good-soft', 'bad', 'bad-soft', 'warn', 'warn-soft', 'focus'].map((name) => {
  const patch = make('div', {});
  patch.style.cssText = `height: 2.5rem; width: 7rem; border: 1px solid var(--edge); background: var(--${name})`;
  return [name, patch] as const;
});

const [good] = field('name', 'Team', {}, 'As the leaderboard shows it.');
const [wrong, input] = field('wrong', 'Paper', { type: 'url', value: 'ftp://example.org', 'aria-invalid': 'true', 'aria-describedby': 'wrong-problem' });
wrong.append(make('p', { class: 'problem', id: 'wrong-problem' }, 'An address begins with https://'));
input.required = false;
const [choice] = labelled('choice', 'Split', make('select', {}, new Option('val_unseen'), new Option('val_seen')));
const [prose] = labelled('prose', 'Instructions', make('textarea', { rows: '3' }), 'Markdown.');

const tab = (text: string, here: boolean) => make('a', { href: '#main', ...(here && { 'aria-current': 'page' }) }, text);
const number = (text: string, name = 'number') => make('td', { class: name, 'data-label': 'SPL, %' }, text);
const withInterval = (mean: number) => {
  const cell = number(mean.toFixed(1), mean > 40 ? 'number best' : 'number');
  cell.append(intervalBar({ low: mean - 4, mean, high: mean + 4 }, [20, 50], 'an interval'));
  return cell;
};
const day = 86_400_000;
const points = [[0, 21], [1, 30], [2, 28], [4, 41]].map(([when, value]) => ({ team: 'Ada', time: Date.UTC(2027, 0, 1) + when! * day, value: value!, name: 'method' }));

main.append(
  crumbs([['/', 'Buildings']], 'Styles'),
  make('div', { class: 'page-head' }, make('h1', {}, 'Styles'), make('p', { class: 'lead' }, 'Every part of web/src/style.css, by the name that pages use. All figures on this page are made up.')),
  section('Type', ...sizes), section('Space', facts(spaces)), section('Colour', facts(colours)),
  section('Button', make('p', { class: 'buttons' }, button('.main', 'main'), button('button'), button('.quiet', 'quiet'),
    make('button', { type: 'button', disabled: '' }, 'disabled'), make('a', { href: '#main', class: 'button' }, 'a.button'))),
  section('Field', form('Send', [good, wrong, choice, prose, make('label', { class: 'row' }, make('input', { type: 'checkbox' }), 'label.row')], async () => toast('A .toast, for five seconds'))),
  section('Card', make('ul', { class: 'cards' }, ...['One', 'Two', 'Three'].map((name) => make('li', { class: 'card' },
    make('div', { class: 'card-picture' }), make('div', { class: 'card-body' }, make('h3', {}, make('a', { href: '#main' }, name)), make('p', {}, '9 rooms, 2 storeys'), make('p', { class: 'note' }, '.card-picture, .card-body')))))),
  section('People',
    make('p', { class: 'buttons' }, button('Review 4', 'main'), menu('More', 'More: a study', [button('Make a copy'), button('Close')])),
    ...dayChart([{ day: '2027-01-01', submitted: 4, reviewed: 1 }, { day: '2027-01-04', submitted: 2, reviewed: 6 }])),
  section('Doors', make('ul', { class: 'doors' }, ...(['explore', 'write', 'walk', 'compete'] as const).map((name) =>
    make('li', {}, icon(name), make('h2', {}, make('a', { href: '#main' }, name)), make('p', {}, 'A line on what is behind it.'))))),
  section('Table', table([make('th', { scope: 'col', 'aria-label': 'Rank' }, '#'), 'Team and method', make('th', { scope: 'col', class: 'number', 'aria-sort': 'descending' }, make('button', { type: 'button' }, 'SPL'), make('span', { class: 'unit' }, '%'))],
    [42.1, 33.5].map((mean, k) => [make('td', { class: 'rank' }, String(k + 1)), make('td', { class: 'rest' }, make('strong', {}, 'Ada'), make('span', { class: 'method' }, 'method')), withInterval(mean)]), { kind: 'stack', label: 'A table' })),
  section('Chart', progressChart(points, 'Ada', 'A chart of made-up numbers')),
  section('Notices', make('p', { class: 'notice' }, '.notice'), make('p', { class: 'notice info' }, '.notice.info'), make('p', { class: 'notice good' }, '.notice.good'), make('p', { class: 'notice bad' }, '.notice.bad'),
    make('p', { class: 'note' }, '.note'), make('p', { class: 'done' }, '.done'), make('p', { class: 'problem' }, '.problem')),
  section('Badges', make('p', { class: 'buttons' }, make('span', { class: 'badge' }, '.badge'), make('span', { class: 'badge good' }, '.good'), make('span', { class: 'badge bad' }, '.bad'), make('span', { class: 'badge wait' }, '.wait'))),
  section('Tabs', make('nav', { class: 'tabs', 'aria-label': 'Tabs' }, tab('Here', true), tab('There', false))),
  section('Progress', make('progress', { max: '8', value: '3', 'aria-label': 'Tasks' })),
  section('States', empty('Nothing yet', '.empty says what would stand here, and how to get it.', button('Do it', 'main')), loading()),
  section('Prose', markdown('### Rules\n\n*One* model a team, **no** test data. See `enfilade run`.\n\n> A quotation.\n\n- first\n- second')),
  section('Token', make('p', { class: 'token' }, 'enf_0123456789abcdef')),
);
