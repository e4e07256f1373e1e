'use strict';

// Episodes step by step: the view, the map, and what the agent attends to in the instruction.

const kActionNames = {
  left: 'turns left', right: 'turns right', up: 'looks up', down: 'looks down',
  forward: 'goes forward', end: 'stops', wait: 'waits', '': 'is out of steps',
};

const actionName = (action) => kActionNames[action] || action;

const kClosing = /^[,.;:!?)]+$/;
const shownWord = (word) => word === '<EOS>' ? '∎' : word;  // the end, which is attended to as well

// The instruction; each word marked by the weight that it has now, the largest fully.
function instructionText(episode, step) {
  if (!episode.words && episode.lines) {  // a dialogue, a language, pieces
    return element('div', {class: 'instruction'},
      ...episode.lines.map((line) => element('p', {}, line)));
  }
  if (!episode.words) return element('p', {class: 'instruction'}, episode.text);
  const text = element('p', {class: 'instruction'});
  const most = step.attention ? d3.max(step.attention) || 1 : 1;
  episode.words.forEach((word, i) => {
    const weight = step.attention ? step.attention[i] : 0;
    const unknown = episode.unknown.includes(i);
    const title = (step.attention ? percent(weight, 1) : '') +
      (unknown ? ' (not in the agent’s vocabulary)' : '');
    const kind = (unknown ? 'unknown ' : '') + (kClosing.test(word) ? 'closing' : '');
    const span = element('span', {title, class: kind || null},
      shownWord(word));
    span.style.backgroundColor = `rgb(var(--heat) / ${(0.75 * weight / most).toFixed(3)})`;
    text.append(kClosing.test(word) ? '' : ' ', span);
  });
  return text;
}

function mostAttended(episode, step) {
  if (!episode.words || !step.attention) return '';
  const order = d3.range(episode.words.length)
    .sort((a, b) => step.attention[b] - step.attention[a]).slice(0, 3);
  return 'Attends most to: ' +
    order.map((i) => `“${shownWord(episode.words[i])}” ${percent(step.attention[i])}`).join(', ') + '.';
}

// Steps by words; darker is more.
function heatMap(episode, current) {
  const steps = episode.steps.filter((step) => step.attention);
  const cell = Math.max(13, Math.min(20, 800 / episode.words.length));  // as wide as the page
  const line = 18;
  const left = 84;
  const top = 78;
  const width = left + cell * episode.words.length + 50;
  const height = top + line * steps.length + 6;
  const svg = d3.create('svg').attr('class', 'heat').attr('role', 'img')
    .attr('viewBox', `0 0 ${width} ${height}`).attr('width', width).attr('height', height)
    .attr('aria-label', 'Attention over the words of the instruction at each step');
  svg.node().style.width = `${width}px`;
  episode.words.forEach((word, i) => {
    svg.append('text').attr('transform',
      `translate(${left + cell * (i + 0.7)},${top - 6}) rotate(-50)`).text(shownWord(word));
  });
  steps.forEach((step, row) => {
    const most = d3.max(step.attention) || 1;
    svg.append('text').attr('class', row === current ? 'current' : null).attr('text-anchor', 'end')
      .attr('x', left - 8).attr('y', top + line * (row + 0.7)).text(`${row} ${step.action}`);
    step.attention.forEach((weight, i) => {
      svg.append('rect').attr('class', 'cell').attr('x', left + cell * i).attr('y', top + line * row)
        .attr('width', cell - 1).attr('height', line - 1)
        .attr('fill-opacity', (0.05 + 0.95 * weight / most).toFixed(3))
        .append('title').text(`step ${row}, “${shownWord(episode.words[i])}”: ${percent(weight, 1)}`);
    });
  });
  if (current < steps.length) {
    svg.append('rect').attr('class', 'row').attr('x', left - 1).attr('y', top + line * current - 1)
      .attr('width', cell * episode.words.length + 1).attr('height', line + 1);
  }
  return element('div', {class: 'scroll', tabindex: '0', role: 'region',
    'aria-label': 'Attention by step and word'}, svg.node());
}

// Null if the data set has no picture of it.
function frameOf(part, step, description) {
  return step.frame === null ? null : picture(part.frames[step.frame], description);
}

function outcome(episode) {
  const word = episode.success ? element('span', {class: 'arrived'}, 'arrived')
    : element('span', {class: 'lost'}, 'did not arrive');
  return element('p', {class: 'note'}, `${episode.scan}, episode ${episode.id}: `, word,
    `, stopped ${metres(episode.error)} from the goal after ${metres(episode.length)}; ` +
    `the shortest way is ${metres(episode.shortest)}.`);
}

// One episode with its controls. Only what changes with the step is drawn again.
class EpisodeView {
  constructor(part, episode) {
    this.part = part;
    this.episode = episode;
    this.index = 0;
    this.text = element('div');
    this.moment = element('div', {class: 'moment'});
    this.heat = element('div');
    this.strip = element('div', {class: 'strip', role: 'group', 'aria-label': 'Steps'});
    const goal = episode.goal ? paragraph(`Yellow on the map: ${episode.goal.label}.`, 'note') : '';
    this.node = element('div', {class: 'episode'}, outcome(episode), this.text, goal,
      this.controls(), this.moment, this.strip, this.heat);
    this.fillStrip();
    this.show(0);
  }

  controls() {
    const last = this.episode.steps.length - 1;
    this.slider = element('input', {type: 'range', min: 0, max: last, step: 1, value: 0,
      'aria-label': 'Step'});
    this.slider.addEventListener('input', () => this.show(Number(this.slider.value)));
    this.back = element('button', {type: 'button', 'aria-label': 'Step before'}, '‹');
    this.back.addEventListener('click', () => this.show(this.index - 1));
    this.on = element('button', {type: 'button', 'aria-label': 'Step after'}, '›');
    this.on.addEventListener('click', () => this.show(this.index + 1));
    this.output = element('output');
    return element('div', {class: 'controls'}, this.back, this.slider, this.on, this.output);
  }

  fillStrip() {
    this.buttons = this.episode.steps.map((step, i) => {
      const button = element('button', {type: 'button', 'aria-label': `Step ${i}`});
      button.append(...[frameOf(this.part, step, ''), `${i} ${step.action || 'over'}`].filter(Boolean));
      button.addEventListener('click', () => this.show(i));
      return button;
    });
    this.strip.append(...this.buttons);
  }

  show(index) {
    const {episode, part} = this;
    this.index = Math.max(0, Math.min(index, episode.steps.length - 1));
    const step = episode.steps[this.index];
    this.slider.value = this.index;
    this.back.disabled = this.index === 0;
    this.on.disabled = this.index === episode.steps.length - 1;
    this.output.textContent =
      `step ${this.index} of ${episode.steps.length - 1}: ${actionName(step.action)}`;
    this.text.replaceChildren(instructionText(episode, step),
      paragraph(mostAttended(episode, step), 'note'));
    const seen = frameOf(part, step, `What the agent sees at step ${this.index}`);
    const map = drawMap(episode, part.buildings[episode.scan], this.index, part.successDistance);
    this.moment.replaceChildren(...[seen, map].filter(Boolean));
    this.buttons.forEach((button, i) => button.setAttribute('aria-pressed', i === this.index));
    const current = this.buttons[this.index];
    this.strip.scrollLeft = current.offsetLeft + (current.offsetWidth - this.strip.clientWidth) / 2;
    if (episode.words) this.heat.replaceChildren(heatMap(episode, this.index));
  }
}

function episodeButtons(part, view) {
  const buttons = [];
  const choices = element('div', {class: 'choices'});
  for (const kind of ['best', 'worst', 'random']) {
    const group = element('div', {role: 'group', 'aria-label': kind}, element('span', {}, kind));
    part.episodes.filter((episode) => episode.kind === kind).forEach((episode) => {
      const button = element('button', {type: 'button', 'aria-pressed': 'false'}, episode.id);
      button.addEventListener('click', () => {
        buttons.forEach((other) => other.setAttribute('aria-pressed', other === button));
        view.replaceChildren(new EpisodeView(part, episode).node);
      });
      buttons.push(button);
      group.append(button);
    });
    if (group.childNodes.length > 1) choices.append(group);
  }
  return {choices, buttons};
}

function drawGallery(section, data) {
  const part = data.gallery;
  if (part.missing) {
    section.append(missing(part.missing));
    return;
  }
  const among = part.withAttention
    ? ` (of the ${part.withAttention} episodes whose attention was kept)` : '';
  section.append(paragraph(`${agentName(part.agent)} on ${part.split}${among}: the best, the ` +
    'worst, and some at random. Blue is the reference path, orange the agent’s.', 'lead'));
  if (part.noAttention) section.append(missing(part.noAttention, 'Attention over words'));
  if (part.noPictures) section.append(missing(part.noPictures, 'What the agent sees'));
  const view = element('div');
  const {choices, buttons} = episodeButtons(part, view);
  section.append(choices, view);
  if (buttons.length > 0) buttons[0].click();
}
