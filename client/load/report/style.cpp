// Colours keep a contrast of 4.5 to 1 to the background in both themes, and differ for the
// colour-blind.
#include "client/load/report/style.h"

namespace sightline::client::load::report {

const char* const kStyle = R"(
:root {
  color-scheme: light dark;
  --paper: #ffffff; --ink: #1b1f24; --soft: #57606a; --line: #d8dee4; --panel: #f6f8fa; --warn: #8a4600;
  --c0: #0b62c4; --c1: #b34700; --c2: #1a7f37; --c3: #8250df;
}
@media (prefers-color-scheme: dark) {
  :root {
    --paper: #12161b; --ink: #e6edf3; --soft: #9da7b1; --line: #343b44; --panel: #1b2128; --warn: #f0b35a;
    --c0: #6cb0ff; --c1: #ff9e57; --c2: #5fd07a; --c3: #c9a5ff;
  }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2rem 1.25rem 3rem; max-width: 54rem; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif;
}
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .3rem; }
p { margin: .3rem 0 .8rem; }
.lead { color: var(--soft); }
.note { border-left: 4px solid var(--warn); background: var(--panel); padding: .5rem .8rem; margin: .6rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: .85rem; }
th, td { text-align: right; padding: .35rem .45rem; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { color: var(--soft); font-weight: 600; white-space: normal; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1rem; margin: .5rem 0; font-size: .9rem; }
dt { color: var(--soft); }
dd { margin: 0; overflow-wrap: anywhere; }
code { font: .85rem/1.4 ui-monospace, "DejaVu Sans Mono", monospace; }
svg { display: block; width: 100%; height: auto; margin: .4rem 0 0; }
svg text { font: 12px system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; fill: var(--ink); }
svg .name { fill: var(--soft); }
svg .grid { stroke: var(--line); stroke-width: 1; }
svg .axis { stroke: var(--soft); stroke-width: 1; }
svg line.mark { stroke: var(--ink); stroke-width: 1.5; stroke-dasharray: 5 4; }
svg text.mark { font-weight: 600; }
svg .curve { fill: none; stroke-width: 2.5; stroke-linejoin: round; }
svg .c0 { stroke: var(--c0); } svg .c1 { stroke: var(--c1); } svg .c2 { stroke: var(--c2); } svg .c3 { stroke: var(--c3); }
svg .f0 { fill: var(--c0); } svg .f1 { fill: var(--c1); } svg .f2 { fill: var(--c2); } svg .f3 { fill: var(--c3); }
footer { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: 1rem; }
@media (max-width: 34rem) {
  body { padding: 1.25rem .8rem 2rem; }
  svg { min-width: 34rem; }
  figure { overflow-x: auto; }
}
figure { margin: 0; }
@media print {
  :root {
    color-scheme: light;
    --paper: #ffffff; --ink: #000000; --soft: #444444; --line: #cccccc; --panel: #f4f4f4; --warn: #8a4600;
    --c0: #0b62c4; --c1: #b34700; --c2: #1a7f37; --c3: #8250df;
  }
  body { max-width: none; padding: 0; font-size: 11pt; }
  section, figure, tr, .note { break-inside: avoid; }
  h2 { break-after: avoid; }
  svg { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
}
@page { margin: 16mm; }
)";

}  // namespace sightline::client::load::report
