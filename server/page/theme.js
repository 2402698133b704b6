// Light or dark, as the system has it or as it was chosen here.

const kTheme = 'sightline-theme';
const kChoices = ['light', 'dark'];  // any other text means the system's

// A browser may forbid to store anything: the choice then lasts until the page is loaded again.
function stored() {
  try {
    return localStorage.getItem(kTheme);
  } catch {
    return null;
  }
}

function store(theme) {
  try {
    localStorage.setItem(kTheme, theme);
  } catch { /* see above */ }
}

function apply(theme) {
  if (kChoices.includes(theme)) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
}

// select: a <select> of system, light and dark.
export function offerThemes(select) {
  select.value = document.documentElement.dataset.theme ?? 'system';
  select.addEventListener('change', () => {
    apply(select.value);
    store(select.value);
  });
}

apply(stored());
