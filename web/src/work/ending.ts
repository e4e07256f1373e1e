/** How a visit ends: thanks, a code, or a form that goes back to where the worker came from. */
import { make } from '../elements/page.ts';
import type { Completion, Visit } from './visit.ts';

/** Mechanical Turk's ExternalQuestion: its own page takes a form. */
function formOf({ action = '', fields = {} }: Completion): HTMLElement {
  const inputs = Object.entries(fields).map(([name, value]) => make('input', { type: 'hidden', name, value }));
  return make('form', { method: 'post', action, target: '_self' }, ...inputs,
    make('p', {}, 'One step is left: submit the assignment.'),
    make('button', { class: 'main' }, 'Submit to Mechanical Turk'));
}

function codeOf({ code = '', url }: Completion): HTMLElement {
  const box = make('div', {}, make('p', {}, 'Your completion code is'), make('p', { class: 'token' }, code));
  if (url) box.append(make('p', {}, make('a', { href: url, class: 'button main' }, 'Back to Prolific')));
  return box;
}

const reasons: Record<NonNullable<Visit['why']>, string> = {
  finished: 'You have done all that was asked of you.',
  'none-left': 'There is nothing more for you to do here: you have done every task that is open to you.',
  'all-leased': 'Others are at work on all that is left. Try again in a minute.',
  closed: 'This collection is closed for now.',
  questions: '',
  'screened-out': 'By your answers, this study is not for you. That is no fault of yours.',
};

/** What a screened-out worker does on a platform. */
const leaveText = 'If you came by Mechanical Turk, return the HIT; on Prolific, return the submission. Else close this page.';

/** @param again asks for a task once more */
export function ending(visit: Visit, again: () => void): HTMLElement {
  const { done, why = 'finished', completion, bonuses } = visit;
  const out = why === 'screened-out';
  const box = make('div', { class: 'narrow' },
    make('h1', { tabindex: '-1' }, done > 0 || out ? 'Thank you' : 'Nothing to do'),
    ...(done > 0 ? [make('p', { class: 'done' }, done === 1 ? 'Your work has been received.' : `Your ${done} tasks have been received.`)] : []),
    make('p', {}, reasons[why]));
  if (bonuses !== undefined) box.append(make('p', {}, bonuses === 1 ? 'One of your walks earned the bonus.' : `${bonuses} of your walks earned the bonus.`));
  if (out && !completion) box.append(make('p', {}, leaveText));
  if (completion?.kind === 'mturk') box.append(formOf(completion));
  if (completion?.kind === 'prolific') box.append(codeOf(completion));
  if (completion?.kind === 'self') box.append(make('p', {}, 'You can close this page.'));
  if (why === 'all-leased') {
    const button = make('button', { type: 'button', class: 'main' }, 'Try again');
    button.addEventListener('click', again);
    box.append(make('p', {}, button));
  }
  return box;
}
