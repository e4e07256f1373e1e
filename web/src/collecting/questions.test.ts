import { describe, expect, it } from 'vitest';
import { parseQuestions } from './questions.ts';

describe('questions', () => {
  const typed = 'Are you at least 18?\n* Yes\nNo\n\n  Choose a colour. \n*Red\n* Blue\nGreen\n';
  const parsed = [
    { question: 'Are you at least 18?', choices: ['Yes', 'No'], accept: ['Yes'] },
    { question: 'Choose a colour.', choices: ['Red', 'Blue', 'Green'], accept: ['Red', 'Blue'] },
  ];
  it('are typed in blocks', () => {
    expect(parseQuestions(typed)).toEqual(parsed);
    expect(parseQuestions(' \n\n ')).toEqual([]);
  });
  it('are refused by their name', () => {
    expect(() => parseQuestions('Why?\n* Because')).toThrow('"Why?": write two choices');
    expect(() => parseQuestions('Why?\nThis\nThat')).toThrow('put a *');
  });
});
