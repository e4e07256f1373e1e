/** Notes to a worker beside the organiser's texts: the number of tasks, their time and pay. */
import type { Collection, Kind } from '../collecting/collections.ts';
import { counted, make } from '../elements/page.ts';
import type { Rejected, Visit } from './visit.ts';

const taskTexts: Record<Kind, string> = {
  write: 'You see a way through a building and write directions for it.',
  walk: 'You read directions and walk by them through a building.',
  describe: 'You see an object in a building and write what to do with it, so that another person finds it.',
  find: 'You read about an object, walk through a building until you see it, and point at it.',
  guide: 'You walk through a building and say on the way what one should do.',
  dialogue: 'With another person you look for an object in a building: one walks and asks, one sees the way and answers.',
};
const amounts: Record<Kind, (n: number) => string> = {
  write: (n) => `${counted(n, 'path')} to describe`, walk: (n) => counted(n, 'walk'), describe: (n) => `${counted(n, 'object')} to describe`,
  find: (n) => `${counted(n, 'object')} to find`, guide: (n) => `${counted(n, 'path')} to guide along`, dialogue: (n) => counted(n, 'dialogue'),
};

function amount(collection: Collection, { of, done, practice = 0 }: Visit): string {
  const practised = practice > 0 ? `, after ${counted(practice, 'practice task')}` : '';
  if (of === undefined) return `As many as you like${practised}`;
  const tasks = amounts[collection.kind](of);
  return `${tasks}${practised}${done > 0 ? `; ${done} of them are done` : ''}`;
}

/** Before one agrees. @param visit absent in a preview */
export function conditions(collection: Collection, visit?: Visit): HTMLElement {
  const rows: [string, string][] = [
    ['Your task', taskTexts[collection.kind]]];
  if (visit) rows.push(['How much', amount(collection, visit)]);
  if (collection.minutes) {
    const all = visit?.of !== undefined && visit.of > 1 ? `, ${counted(Math.round(collection.minutes * visit.of), 'minute')} in all` : '';
    rows.push(['Time', `About ${counted(collection.minutes, 'minute')} each${all}`]);
  }
  if (collection.pay) rows.push(['Pay', collection.pay]);
  return make('dl', { class: 'conditions' }, ...rows.map(([name, text]) => make('div', {}, make('dt', {}, name), make('dd', {}, text))));
}

/** "Task 3 of 8", with a bar. */
export function progress({ done, of, task }: Visit): HTMLElement {
  if (task?.practice) return make('p', { class: 'progress' }, make('strong', {}, 'Practice'), ': this one does not count.');
  const box = make('p', { class: 'progress' }, make('span', {}, of === undefined ? `Task ${done + 1}` : `Task ${Math.min(done + 1, of)} of ${of}`));
  if (of !== undefined) box.append(make('progress', { max: String(of), value: String(done), 'aria-label': 'Done' }));
  return box;
}

/** Tasks that were not accepted; nothing if there are none. */
export function notAccepted({ rejected = [] }: Visit): HTMLElement[] {
  if (rejected.length === 0) return [];
  const entry = ({ task, submitted, reason }: Rejected) => make('li', {}, `Task ${task} of ${submitted.slice(0, 10)}: ${reason}`);
  return [make('div', { class: 'notice' },
    make('p', {}, rejected.length === 1 ? 'One of your tasks was not accepted:' : `${rejected.length} of your tasks were not accepted:`),
    make('ul', {}, ...rejected.map(entry)))];
}

/** The result of a practice task: nothing of it helps with another path. */
export function practised({ practised: result }: Visit): HTMLElement[] {
  if (!result) return [];
  if (result.reached !== undefined) {
    const far = result.distance === undefined ? '' : ` You stopped ${result.distance.toFixed(1)} m from it.`;
    const missed = result.distance === undefined ? 'That was not the object.' : 'You did not find the goal: it counts as found within 3 m.';
    return [make('p', { class: result.reached ? 'done' : 'problem' }, (result.reached ? 'You found the goal.' : missed) + far),
    make('p', { class: 'note' }, 'Tasks that count show no result, so that one does not help with another.')];
  }
  if (result.example) return [make('p', {}, 'Another person wrote for the same path:'), make('blockquote', { class: 'example' }, result.example)];
  return [];
}
