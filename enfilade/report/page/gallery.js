'use strict';

// Episodes step by step: the view, the map, and what the agent attends to in the instruction.

const kActionNames = {
  left: 'turns left', right: 'turns right', up: 'looks up', down: 'looks down',
  forward: 'goes forward', end: 'stops', wait: 'waits', '': 'is out of steps',
  go: 'goes on', jump: 'goes to a place further away',
  back: 'is back where stopping was likeliest',
};

const actionName = (action) => kActionNames[action] || action;

const kClosing = /^[,.;:!?)]+$/;
// Ends, which are attended to as well; marks of pieces of words are left out.
const shownWord = (word) => ['<EOS>', '[SEP]', '</s>'].includes(word) ? '∎'
  : ['<BOS>', '[CLS]', '<s>'].includes(word) ? '▸' : word.replace(/^(##|▁)(?=.)/, '');
const joinsOn = (word) => kClosing.test(word) || word.startsWith('##');

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
    text.append(joinsOn(word) ? '' : ' ', span);
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
    svg.append('text').attr('class', step === episode.steps[current] ? 'current' : null).attr('text-anchor', 'end')
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

function outcomeWords(episode) {
  const word = episode.success ? element('span', {class: 'arrived'}, 'arrived')
    : element('span', {class: 'lost'}, 'did not arrive');
  return [word, `, stopped ${metres(episode.error)} from the goal after ${metres(episode.length)}`];
}

function outcome(episode) {
  return element('p', {class: 'note'}, `${episode.scan}, episode ${episode.id}: `,
    ...outcomeWords(episode), `; the shortest way is ${metres(episode.shortest)}.`);
}

const wideEnough = () => window.innerWidth > 700;

// What one agent sees and does in an episode. Only what changes with the step is drawn again.
class AgentView {
  // `alone`: no other agent is beside it
  constructor(part, episode, alone) {
    Object.assign(this, {part, episode, alone});
    this.last = episode.steps.length - 1;
    this.text = element('div');
    const chooses = episode.steps.some((step) => step.choices);
    this.moment = element('div', {class: chooses ? 'moment deciding' : 'moment'});
    this.heat = element('div');
    this.says = element('p', {class: 'note'});
    this.column = element('div', {class: 'column'}, element('h3', {}, agentName(episode.agent)),
      element('p', {class: 'note'}, ...outcomeWords(episode), '.'), this.says, this.moment,
      this.text);
  }

  surroundings(index) {
    const zoom = wideEnough() ? (this.alone ? 1 : 1.9) : 1.3;
    const view = panoramaView(this.part, this.episode, index, zoom);
    if (view === null) return null;
    return element('div', {class: this.alone ? 'scroll around alone' : 'scroll around',
      tabindex: '0', role: 'region', 'aria-label': 'All around'}, view);
  }

  show(wanted) {
    const {episode, part} = this;
    const index = Math.min(wanted, this.last);
    const step = episode.steps[index];
    const seen = frameOf(part, step, `What the agent sees at step ${index}`);
    const map = drawMap(episode, part.buildings[episode.scan], index, part.successDistance);
    const around = this.surroundings(index);
    this.moment.replaceChildren(...[around, seen, map, choiceList(step)].filter(Boolean));
    if (around) around.scrollLeft = panoramaFocus(step) * around.scrollWidth - around.clientWidth / 2;
    this.says.textContent = wanted > this.last ? `ended at step ${this.last}`
      : `step ${index} of ${this.last}: ${actionName(step.action)}`;
    if (!this.alone) {
      if (episode.words && step.attention) this.text.replaceChildren(instructionText(episode, step));
      else this.text.replaceChildren();
      return;
    }
    this.text.replaceChildren(instructionText(episode, step),
      paragraph(mostAttended(episode, step), 'note'));
    if (episode.words) this.heat.replaceChildren(heatMap(episode, index));
  }
}

// One episode with its controls, of one agent or of several side by side.
class EpisodeView {
  constructor(part, episode, agents) {
    this.part = part;
    this.episode = episode;
    this.index = 0;
    const several = agents.length > 1;
    this.views = agents.map((agent) => new AgentView(part, agent, !several));
    this.last = d3.max(this.views, (view) => view.last);
    const goal = episode.goal ? paragraph(`Yellow on the map: ${episode.goal.label}.`, 'note') : '';
    this.strip = element('div', {class: 'strip', role: 'group', 'aria-label': 'Steps'});
    this.node = element('div', {class: 'episode'});
    if (several) {
      const columns = element('div', {class: 'columns'}, ...this.views.map((view) => view.column));
      const plain = {...episode, words: undefined};
      this.node.append(element('p', {class: 'note'}, `${episode.scan}, episode ${episode.id}; the ` +
        `shortest way is ${metres(episode.shortest)}.`), instructionText(plain, {}), goal,
      this.controls(), columns);
    } else {
      const [view] = this.views;
      this.node.append(outcome(view.episode), view.text, goal, this.controls(), view.moment,
        this.strip, view.heat);
      this.fillStrip(view.episode);
    }
    this.show(0);
  }

  controls() {
    this.slider = element('input', {type: 'range', min: 0, max: this.last, step: 1, value: 0,
      'aria-label': 'Step'});
    this.slider.addEventListener('input', () => this.show(Number(this.slider.value)));
    this.back = element('button', {type: 'button', 'aria-label': 'Step before'}, '‹');
    this.back.addEventListener('click', () => this.show(this.index - 1));
    this.on = element('button', {type: 'button', 'aria-label': 'Step after'}, '›');
    this.on.addEventListener('click', () => this.show(this.index + 1));
    this.output = element('output');
    return element('div', {class: 'controls'}, this.back, this.slider, this.on, this.output);
  }

  fillStrip(episode) {
    this.buttons = episode.steps.map((step, i) => {
      const button = element('button', {type: 'button', 'aria-label': `Step ${i}`});
      const seen = step.panorama ? thumbnail(this.part, step) : frameOf(this.part, step, '');
      button.append(...[seen, `${i} ${step.action || 'over'}`].filter(Boolean));
      button.addEventListener('click', () => this.show(i));
      return button;
    });
    this.strip.append(...this.buttons);
  }

  show(index) {
    this.index = Math.max(0, Math.min(index, this.last));
    this.slider.value = this.index;
    this.back.disabled = this.index === 0;
    this.on.disabled = this.index === this.last;
    this.views.forEach((view) => view.show(this.index));
    const alone = this.views.length === 1;
    this.output.textContent = alone ? this.views[0].says.textContent
      : `step ${this.index} of ${this.last}`;
    if (!alone) return;
    this.buttons.forEach((button, i) => button.setAttribute('aria-pressed', i === this.index));
    const current = this.buttons[this.index];
    this.strip.scrollLeft = current.offsetLeft + (current.offsetWidth - this.strip.clientWidth) / 2;
  }
}

// The agents of an episode: that of the gallery, and others that walked it.
function agentsOf(part, episode) {
  const first = {...episode, agent: part.agent};
  return [first, ...(episode.others || []).map((other) =>
    ({...episode, words: undefined, unknown: undefined, ...other}))];
}

// Buttons that put agents beside each other or take them away; at least one stays.
function agentButtons(part, redraw) {
  const names = agentsOf(part, part.episodes[0]).map((one) => one.agent);
  const shown = new Set(names);
  const group = element('div', {role: 'group', 'aria-label': 'agents'},
    element('span', {}, 'agents'));
  names.forEach((name) => {
    const button = element('button', {type: 'button', 'aria-pressed': 'true'}, agentName(name));
    button.addEventListener('click', () => {
      if (shown.has(name) && shown.size > 1) shown.delete(name);
      else shown.add(name);
      button.setAttribute('aria-pressed', String(shown.has(name)));
      redraw();
    });
    group.append(button);
  });
  return {shown, node: names.length > 1 ? element('div', {class: 'choices'}, group) : ''};
}

function episodeButtons(part, show) {
  const buttons = [];
  const choices = element('div', {class: 'choices'});
  for (const kind of ['best', 'worst', 'random']) {
    const group = element('div', {role: 'group', 'aria-label': kind}, element('span', {}, kind));
    part.episodes.filter((episode) => episode.kind === kind).forEach((episode) => {
      const button = element('button', {type: 'button', 'aria-pressed': 'false'}, episode.id);
      button.addEventListener('click', () => {
        buttons.forEach((other) => other.setAttribute('aria-pressed', other === button));
        show(episode);
      });
      buttons.push(button);
      group.append(button);
    });
    if (group.childNodes.length > 1) choices.append(group);
  }
  return {choices, buttons};
}

const kChoosingText = 'Agents that choose among viewpoints: circles are where they could go, larger ' +
  'for more probable, filled for the one that they choose; dots on the map are places that they have ' +
  'visited (filled) or only seen (hollow), thin lines the ways between these that they know.';

function drawGallery(section, data) {
  const part = data.gallery;
  const chooses = part.episodes.some((one) => agentsOf(part, one)
    .some((agent) => agent.steps.some((step) => step.choices)));
  const among = [
    part.withAttention ? `the ${part.withAttention} episodes whose attention was kept` : '',
    part.leastTexels ? `buildings with pictures of ${part.leastTexels} texels a face or more` : '',
  ].filter(Boolean).map((of) => ` (of ${of})`).join('');
  section.append(paragraph(`${agentName(part.agent)} on ${part.split}${among}: the best, the ` +
    'worst, and some at random. Blue is the reference path, orange the agent’s.', 'lead'));
  if (chooses) section.append(paragraph(kChoosingText, 'note'));
  if (part.noAttention) leaveOut('Attention over words', part.noAttention);
  if (part.noPictures) leaveOut('What the agent sees', part.noPictures);
  if (part.episodes.length === 0) return;
  const view = element('div');
  let current = part.episodes[0];
  let step = 0;
  let drawn = null;
  const draw = () => {
    const agents = agentsOf(part, current).filter((one) => picked.shown.has(one.agent));
    drawn = new EpisodeView(part, current, agents);
    view.replaceChildren(drawn.node);
    drawn.show(step);
  };
  const picked = agentButtons(part, () => {
    step = drawn.index;
    draw();
  });
  const {choices, buttons} = episodeButtons(part, (episode) => {
    current = episode;
    step = 0;
    draw();
  });
  section.append(choices, picked.node, view);
  if (buttons.length > 0) buttons[0].click();
}
