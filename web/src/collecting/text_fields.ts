/** Fields for texts in Markdown, for questions to workers, and for a collection's rules. */
import { field, labelled } from '../elements/forms.ts';
import { markdown } from '../elements/markdown.ts';
import { make } from '../elements/page.ts';
import type { Collection } from './collections.ts';

/** What names in links look like, as the server takes them. */
export const namePattern = '[a-z0-9_\\-]{1,40}';

/** A text in Markdown, and how it will look. */
export function prose(id: string, text: string): [HTMLElement, HTMLTextAreaElement] {
  const shown = make('div');
  const look = make('details', {}, make('summary', {}, 'As workers see it'), shown);
  const [box, area] = labelled(id, text, make('textarea', { rows: '9', maxlength: '20000', required: '' }), 'Markdown; HTML is shown as text.');
  const show = () => { if (look.open) shown.replaceChildren(markdown(area.value)); };
  look.addEventListener('toggle', show);
  area.addEventListener('input', show);
  box.append(look);
  return [box, area];
}

/** Questions to workers, a block each. */
export function questionField(id: string, text: string, note: string): [HTMLElement, HTMLTextAreaElement] {
  return labelled(id, text, make('textarea', { rows: '5', placeholder: 'Are you at least 18 years old?\n* Yes\nNo' }), note);
}

/** Rules of a collection that can be changed later, too. @param after the end of the fields' ids */
export function ruleFields(after: string, now?: Collection): { box: HTMLElement; read(): object } {
  const number = (
    id: string, text: string, most: number, note: string, value: number | undefined, attributes: Record<string, string> = {},
  ): [HTMLElement, HTMLInputElement] => {
    const [box, input] = field(id + after, text, { type: 'number', min: '1', max: String(most), placeholder: 'default', ...attributes }, note);
    input.required = false;
    if (value) input.value = String(value);
    return [box, input];
  };
  const [payBox, pay] = field(`pay${after}`, 'Pay, as workers read it',
    { maxlength: '200', placeholder: '$1.20 a path', ...(now?.pay && { value: now.pay }) });
  pay.required = false;
  const [minutesBox, minutes] = number('minutes', 'Minutes that a task takes', 600, now?.progress?.minutes
    ? `So far the median is ${now.progress.minutes.toFixed(1)}.` : 'Workers see it before they agree.', now?.minutes,
  { step: '0.5', min: '0.5', placeholder: 'not said' });
  const [perBox, per] = number('per-item', 'Different workers for each', 100,
    'Default: 3 where people write, 1 where they walk, 2 for a dialogue, which takes two.', now?.per_item);
  const [leaseBox, lease] = number('lease', 'Minutes until an inactive task goes to another worker', 1440, 'Default: 30.', now?.lease_minutes);
  const [visitBox, visit] = number('visit', 'Tasks per visit', 1000, 'Default: all of them with a link that you send, else 1.', now?.tasks_per_visit);
  const [everyBox, every] = number('check-every', 'Tasks from one attention check to the next', 1000, 'Default: 3.', now?.check_every);
  const more = make('details', {}, make('summary', {}, 'More'), perBox, leaseBox, visitBox, everyBox);
  const optional = (key: string, input: HTMLInputElement) => (input.value ? { [key]: Number(input.value) } : {});
  return {
    box: make('div', {}, payBox, minutesBox, more),
    read: () => ({
      ...(pay.value.trim() !== (now?.pay ?? '') && { pay: pay.value.trim() }), ...optional('minutes', minutes),
      ...optional('per_item', per), ...optional('lease_minutes', lease), ...optional('tasks_per_visit', visit), ...optional('check_every', every),
    }),
  };
}
