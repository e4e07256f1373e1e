'use strict';

// How an agent that chooses among viewpoints chose: its candidates on what is seen all around and
// on the map as it grows, their probabilities, and how much the map counted.

const kMostListed = 7;
const kPanorama = {width: 800, height: 200};  // 360 by 90 degrees

// Letters of a step's choices, the likeliest first; stop has none. Index of a choice -> its letter.
function choiceLetters(step) {
  const order = d3.range(step.choices.length).filter((i) => step.choices[i].v !== null)
    .sort((a, b) => step.choices[b].p - step.choices[a].p);
  const letters = new Map();
  order.forEach((choice, i) => letters.set(choice, i < 26 ? String.fromCharCode(65 + i) : '·'));
  return letters;
}

// Viewpoints that the agent has been at when it makes a step's choice, those passed through too.
function wayUntil(episode, index) {
  const way = [episode.steps[0].v];
  for (let i = 0; i < index; ++i) {
    const on = [...(episode.steps[i].way || []), episode.steps[i + 1].v];
    for (const v of on) if (v !== way[way.length - 1]) way.push(v);
  }
  return way;
}

const goesTo = (step) => {
  if (!step.choices) return [];
  const to = step.choices[step.chosen].v;
  if (to === null) return [];
  return [step.v, ...(step.way.length > 0 ? step.way : [to])];
};

// --- all around -----------------------------------------------------------------------------

const wrapped = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));

// The place of a direction in a panorama whose middle is where the agent looks.
function panoramaPlace(step, heading, elevation) {
  const scale = kPanorama.width / (2 * Math.PI);
  const x = kPanorama.width / 2 + scale * wrapped(heading - step.heading);
  const y = kPanorama.height / 2 - scale * elevation;
  return [x, Math.max(16, Math.min(kPanorama.height - 16, y))];
}

// What is to be in the middle where the panorama does not fit, from 0 to 1: where it goes.
function panoramaFocus(step) {
  const chosen = step.choices && step.choices[step.chosen];
  if (!chosen || chosen.heading === undefined) return 0.5;
  return panoramaPlace(step, chosen.heading, 0)[0] / kPanorama.width;
}

function drawSurroundings(svg, source, step) {
  // The picture looks north: turned so that the agent's heading is in the middle.
  const {width, height} = kPanorama;
  const shift = ((-step.heading / (2 * Math.PI)) % 1 + 1) % 1 * width;
  for (const x of [shift - width, shift]) {
    svg.append('image').attr('href', source).attr('x', x).attr('y', 0)
      .attr('width', width + 0.7).attr('height', height)  // over the seam
      .attr('preserveAspectRatio', 'none');
  }
}

// What an agent of six actions sees of it: 75 by 60 degrees.
function drawSight(svg, step) {
  const [x, y] = panoramaPlace(step, step.heading, step.elevation);
  const scale = kPanorama.width / 360;
  svg.append('rect').attr('class', 'field').attr('width', kFieldOfView * scale)
    .attr('height', 60 * scale).attr('x', x - kFieldOfView / 2 * scale).attr('y', y - 30 * scale);
}

// Places of the candidates, the likeliest first; one that would hide another stands above it.
function candidatePlaces(step, zoom) {
  const places = [];
  const order = d3.range(step.choices.length).filter((i) => step.choices[i].heading !== undefined)
    .sort((a, b) => step.choices[b].p - step.choices[a].p);
  for (const index of order) {
    const choice = step.choices[index];
    const [x, y] = panoramaPlace(step, choice.heading, choice.elevation);
    const hidden = places.filter((other) => Math.abs(other.x - x) < 26 * zoom).length;
    places.push({index, x, y: Math.max(14 * zoom, y - 30 * zoom * hidden)});
  }
  return places;
}

function drawCandidate(svg, step, {index, x, y}, letter, zoom) {
  const choice = step.choices[index];
  const chosen = index === step.chosen;
  const mark = svg.append('g').attr('class', chosen ? 'candidate chosen' : 'candidate')
    .attr('transform', `translate(${x.toFixed(1)},${y.toFixed(1)}) scale(${zoom})`);
  mark.append('title').text(`${letter}: ${percent(choice.p, 1)}`);
  mark.append('circle').attr('r', (5 + 9 * Math.sqrt(choice.p)).toFixed(1));
  mark.append('text').attr('class', 'letter').attr('dy', '.35em').text(letter);
  mark.append('text').attr('class', 'share').attr('x', 16).attr('y', 4).text(percent(choice.p));
}

function panoramaView(part, episode, index, zoom) {
  const step = episode.steps[index];
  if (!step.panorama) return null;
  const svg = d3.create('svg').attr('class', 'panorama').attr('role', 'img')
    .attr('viewBox', `0 0 ${kPanorama.width} ${kPanorama.height}`)
    .attr('aria-label', `All around ${agentName(episode.agent)} at step ${index}`);
  drawSurroundings(svg, part.panoramas[step.panorama], step);
  if (!step.choices) {
    if (episode.steps.some((s) => s.choices)) return svg.node();  // it has stopped
    drawSight(svg, step);
    return svg.node();
  }
  const letters = choiceLetters(step);
  for (const place of candidatePlaces(step, zoom).reverse()) {  // the likeliest on top
    drawCandidate(svg, step, place, letters.get(place.index), zoom);
  }
  return svg.node();
}

// Where the agent looks, as a small picture.
function thumbnail(part, step) {
  const node = element('span', {class: 'thumbnail'});
  const middle = ((step.heading / (2 * Math.PI) + 0.5) % 1 + 1) % 1;  // the picture looks north
  node.style.backgroundImage = `url("${part.panoramas[step.panorama]}")`;
  // 15 rem wide, of which 5 are shown.
  node.style.backgroundPosition = `${(2.5 - 15 * middle).toFixed(3)}rem 0`;
  return node;
}

// --- the map that the agent has drawn -------------------------------------------------------

// Nodes as [viewpoint, visited, probability of stop]. An agent without a map knows its way and
// the neighbours of where it is.
function knownNodes(episode, index) {
  const step = episode.steps[index];
  if (step.nodes) return step.nodes;
  const last = episode.steps.slice(0, index + 1).reverse().find((s) => s.nodes);
  if (!step.choices && last) return last.nodes;  // after the last choice
  const been = wayUntil(episode, index);
  const seen = (step.choices || []).map((choice) => choice.v)
    .filter((v) => v !== null && !been.includes(v));
  return [...[...new Set(been)].map((v) => [v, true, null]), ...seen.map((v) => [v, false, null])];
}

function drawKnown(svg, building, place, episode, index) {
  const nodes = knownNodes(episode, index);
  const known = new Map(nodes.map(([v, visited]) => [v, visited]));
  for (const [a, b] of building.edges) {
    if (!known.has(a) || !known.has(b) || !(known.get(a) || known.get(b))) continue;
    const [x1, y1] = place.at(a);
    const [x2, y2] = place.at(b);
    svg.append('line').attr('class', 'known').attr('x1', x1).attr('y1', y1)
      .attr('x2', x2).attr('y2', y2);
  }
  for (const [v, visited, stop] of nodes) {
    const [x, y] = place.at(v);
    const node = svg.append('circle').attr('class', visited ? 'visited' : 'open')
      .attr('r', 4).attr('cx', x).attr('cy', y);
    const says = stop === null ? '' : `; to stop there had ${percent(stop, 1)}`;
    node.append('title').text((visited ? 'visited' : 'seen, not visited') + says);
  }
}

// Where it could go, by probability, and where it goes.
function drawChoices(svg, place, step) {
  if (!step.choices) return;
  const letters = choiceLetters(step);
  const way = goesTo(step);
  if (way.length > 1) drawWay(svg, place, way, way.length > 2 ? 'goes jump' : 'goes');
  const order = [...letters.keys()].reverse();
  for (const i of order) {
    const choice = step.choices[i];
    const [x, y] = place.at(choice.v);
    const mark = svg.append('g').attr('class', i === step.chosen ? 'option chosen' : 'option')
      .attr('transform', `translate(${x.toFixed(1)},${y.toFixed(1)})`);
    mark.append('circle').attr('r', (4 + 7 * Math.sqrt(choice.p)).toFixed(1))
      .append('title').text(`${letters.get(i)}: ${percent(choice.p, 1)}`);
    if (order.length - order.indexOf(i) > kMostListed && i !== step.chosen) continue;
    mark.append('text').attr('class', 'letter').attr('y', choice.p > 0.06 ? '.35em' : -7)
      .text(letters.get(i));
  }
}

// --- probabilities --------------------------------------------------------------------------

function shareBar(step) {
  if (step.share === undefined) return null;
  const map = element('span', {class: 'by-map'});
  map.style.width = `${(100 * step.share).toFixed(1)}%`;
  return element('div', {class: 'fusion'},
    element('div', {class: 'fusion-names'},
      element('span', {}, `map ${percent(step.share)}`),
      element('span', {}, `what is seen ${percent(1 - step.share)}`)),
    element('div', {class: 'fusion-bar', role: 'img',
      'aria-label': `The map counts for ${percent(step.share)}`}, map));
}

function branchTexts(choice) {
  const texts = [];
  if (choice.map !== undefined) texts.push(`map ${percent(choice.map)}`);
  if (choice.view !== undefined) texts.push(`seen ${percent(choice.view)}`);
  return texts.join(', ');
}

function choiceRow(step, index, letter) {
  const choice = step.choices[index];
  const chosen = index === step.chosen;
  const bar = element('span', {class: 'probability'});
  bar.style.width = `${Math.max(0.5, 100 * choice.p).toFixed(1)}%`;
  const far = choice.v !== null && choice.heading === undefined;
  const name = choice.v === null ? 'stop' : `${letter}${far ? ' (on the map)' : ''}`;
  return element('li', {class: chosen ? 'chosen' : null},
    element('span', {class: 'name'}, name),
    element('span', {class: 'track'}, bar),
    element('span', {class: 'value'}, percent(choice.p, choice.p < 0.1 ? 1 : 0)),
    element('span', {class: 'branches'}, branchTexts(choice)));
}

// Bars of the likeliest choices, of stop and of the chosen one; null where there is no choice.
function choiceList(step) {
  if (!step.choices) return null;
  const letters = choiceLetters(step);
  const order = d3.range(step.choices.length).sort((a, b) => step.choices[b].p - step.choices[a].p);
  const shown = order.filter((i, rank) =>
    rank < kMostListed || step.choices[i].v === null || i === step.chosen);
  const list = element('ol', {class: 'probabilities', 'aria-label': 'Choices by probability'},
    ...shown.map((i) => choiceRow(step, i, letters.get(i))));
  const left = order.length - shown.length;
  const more = left > 0 ? paragraph(`and ${left} less likely`, 'note') : null;
  const object = step.object ? paragraph(`It would name object ${step.object} here.`, 'note') : null;
  const hint = letters.size === 0 ? null : paragraph('Letters are those on picture and map.', 'note');
  return element('div', {class: 'choosing'}, shareBar(step), list, more, object, hint);
}
