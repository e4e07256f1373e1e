/** A screening, or an attention check: questions with one answer each. */
import { form } from '../elements/forms.ts';
import { make } from '../elements/page.ts';
import type { Question, Visit, WorkApi } from './visit.ts';

function fieldOf({ question, text, choices }: Question): HTMLElement {
  const name = `question-${question}`;
  return make('fieldset', {}, make('legend', {}, text), ...choices.map((choice) =>
    make('label', { class: 'row choice' }, make('input', { type: 'radio', name, value: choice, required: '' }), choice)));
}

/** @param proceed gets the visit once all are answered */
export function questionForm(questions: readonly Question[], api: WorkApi, proceed: (visit: Visit) => void): HTMLElement {
  const fields = questions.map(fieldOf);
  const element: HTMLFormElement = form('Next', fields, async () => {
    const data = new FormData(element);
    proceed(await api.answer(questions.map(({ question }) => ({ question, choice: String(data.get(`question-${question}`)) }))));
  });
  return element;
}
