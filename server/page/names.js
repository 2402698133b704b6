// Names of nodes as elements. A name can have any letters: what they do to the direction of text ends with the name.

function isolated(text) {
  const element = document.createElement('bdi');
  element.textContent = text;
  return element;
}

// A name, or that there is none, and the id.
export function nameParts(id, name) {
  const shown = isolated(name || 'no name'), number = document.createElement('span');
  shown.className = name ? 'name' : 'name quiet';
  number.className = 'quiet id';
  number.textContent = id;
  return [shown, number];
}

// Names from a root down.
export function pathOf(names) {
  const path = document.createElement('span');
  names.forEach((name, i) => path.append(...(i > 0 ? [' / '] : []), isolated(name)));
  return path;
}
