'use strict';

// What all parts share: making elements, numbers for people, the looks of splits. Text comes from
// strangers (instructions): it goes in as text nodes and attributes, never as HTML.

function element(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (value !== undefined && value !== null) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

function paragraph(text, kind) {
  return element('p', {class: kind}, text);
}

// What the page leaves out, and why: a sentence. All of it takes one line at the page's end.
const leftOut = new Map();  // a sentence -> what it is about

function leaveOut(what, why) {
  leftOut.set(why, [...(leftOut.get(why) || []), what]);
}

function leftOutLine() {
  const parts = [...leftOut].map(([why, what]) => `${what.join(', ')}: ${why}`);
  return element('p', {class: 'missing', id: 'left-out'}, `Left out: ${parts.join(' ')}`);
}

const percent = (share, digits = 0) =>
  Number.isFinite(share) ? `${(100 * share).toFixed(digits)} %` : '–';
const metres = (value, digits = 1) => Number.isFinite(value) ? `${value.toFixed(digits)} m` : '–';

// "val_unseen" as people say it.
function splitName(split) {
  return {train: 'train', val_seen: 'seen', val_unseen: 'unseen', test: 'test'}[split] || split;
}

function longSplitName(split) {
  const names = {
    train: 'Training buildings', val_seen: 'Seen buildings', val_unseen: 'Unseen buildings',
  };
  return split in names ? `${names[split]} (${split})` : split;
}

function splitClass(split) {
  const known = {train: 'split-train', val_seen: 'split-seen', val_unseen: 'split-unseen'};
  return known[split] || 'split-other';
}

const kSplitOrder = ['train', 'val_seen', 'val_unseen', 'test'];

function inOrder(splits) {
  const rank = (split) => kSplitOrder.includes(split) ? kSplitOrder.indexOf(split) : Infinity;
  return [...splits].sort((a, b) => d3.ascending(rank(a), rank(b)) || a.localeCompare(b));
}

function agentName(agent) {
  const names = {
    shortest: 'Shortest', reference: 'Reference', random: 'Random',
    duet: 'DUET', panoramic: 'Panoramic LSTM', seq2seq: 'Sequence to sequence',
    teacher: 'Teacher-forcing', student: 'Student-forcing',
    'teacher-forcing': 'Teacher-forcing', 'student-forcing': 'Student-forcing',
  };
  const [, base, seed] = /^(.+?)(?:-([0-9]+))?$/.exec(agent) || [null, agent];
  return (names[base] || base) + (seed ? `, run ${seed}` : '');
}

// What lines of a chart mean; `filled`: the split that has an area too, if any.
function legend(splits, filled) {
  const list = element('ul', {class: 'legend'});
  for (const split of inOrder(splits)) {
    const swatch = d3.create('svg').attr('viewBox', '0 0 26 12').attr('aria-hidden', 'true');
    if (split === filled) {
      swatch.append('rect').attr('class', `area ${splitClass(split)}`)
        .attr('y', 2).attr('width', 26).attr('height', 10);
    }
    swatch.append('path').attr('class', `line ${splitClass(split)}`)
      .attr('d', split === filled ? 'M1,2H25' : 'M1,6H25');
    list.append(element('li', {}, swatch.node(), longSplitName(split)));
  }
  return list;
}
