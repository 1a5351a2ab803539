"""How an HTML report looks: one column of text, drawings side by side, light and dark, screen and paper."""

from hjsolve.reports.document.drawing_style import STYLE

CSS = """
:root{--paper:#fffdf8;--ink:#22262b;--soft:#666b72;--rule:#d9d5cc;--blue:#2f5f8f;--red:#b8402a;--wash:#f5f1e8;--green:#2e7044;--amber:#8a6100;
--serif:"Iowan Old Style","Palatino Linotype",Palatino,"Book Antiqua",Georgia,"DejaVu Serif",serif;
--sans:system-ui,-apple-system,"Segoe UI","Helvetica Neue","DejaVu Sans",sans-serif}
@media (prefers-color-scheme:dark){:root{--paper:#16191d;--ink:#e6e3dc;--soft:#a2a6ad;--rule:#3b4048;--blue:#7fb2e5;
--red:#f0846b;--wash:#1f242a;--green:#7cc495;--amber:#e0b45c}}
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%;text-size-adjust:100%}
body{margin:0 auto;padding:2.6rem 1.25rem 4rem;max-width:54rem;background:var(--paper);color:var(--ink);
font:1.0625rem/1.58 var(--serif);overflow-wrap:break-word}
h1{font-size:clamp(1.6rem,1.2rem + 2vw,2.3rem);line-height:1.18;font-weight:600;margin:0 0 .3rem;text-wrap:balance}
h2{font-size:1.32rem;line-height:1.25;font-weight:600;margin:3rem 0 .8rem;
padding-top:.9rem;border-top:1px solid var(--rule)}
p{margin:.75rem 0;max-width:42rem}
a{color:var(--blue);text-decoration-thickness:1px;text-underline-offset:.15em}
code{font:.86em/1.4 ui-monospace,"SF Mono",Menlo,Consolas,"DejaVu Sans Mono",monospace;
background:var(--wash);padding:.08em .32em;
border-radius:3px;overflow-wrap:anywhere}
.id{margin:0 0 1.2rem}
.answer{font-size:1.16rem;line-height:1.5;margin:1.1rem 0 1.3rem;
padding:.15rem 0 .15rem 1rem;border-left:3px solid var(--verdict)}
.answer{--verdict:var(--soft)}.answer.yes{--verdict:var(--green)}.answer.no{--verdict:var(--red)}.answer.open{--verdict:var(--amber)}
.answer strong,.answer .sign{color:var(--verdict)}
nav ol{margin:0;padding:0;list-style:none;display:flex;flex-wrap:wrap;gap:.15rem 1.15rem;font:.86rem/1.7 var(--sans)}
math{font-family:"Latin Modern Math","STIX Two Math","Cambria Math","Libertinus Math","DejaVu Math TeX Gyre",math;
font-size:1em}
math[display=block]{margin:0;text-align:left;width:max-content}
math .lines{text-align:left}
math .lines>mtr>mtd{padding:.3em 0}
.formula{display:flex;align-items:center;gap:1rem;margin:.55rem 0;padding-left:1.4rem}
.formula .scroll{flex:1 1 auto;min-width:0;padding:.3rem 0}
.tag{flex:none;font:.78rem/1.3 var(--sans);color:var(--soft);max-width:9rem;text-align:right}
.scroll{overflow-x:auto;overflow-y:hidden;scrollbar-width:thin}
.scroll:focus-visible{outline:2px solid var(--blue);outline-offset:3px}
.steps{margin:.8rem 0;padding-left:1.4rem}
.steps li{margin:.5rem 0 .9rem}
.steps li::marker{color:var(--soft);font:.9rem var(--sans)}
.steps p{margin:.2rem 0}
.steps .formula{padding-left:0}
.note{font:.92rem/1.5 var(--sans);color:var(--soft);background:var(--wash);padding:.7rem .95rem;border-radius:4px}
table{border-collapse:collapse;margin:.9rem 0 1.2rem;font:.92rem/1.45 var(--sans);font-variant-numeric:tabular-nums}
caption{text-align:left;font-size:.84rem;color:var(--soft);padding:0 0 .45rem;caption-side:top}
th,td{text-align:left;vertical-align:baseline;padding:.42rem 1.3rem .42rem 0;font-weight:400}
thead th{font-size:.82rem;color:var(--soft);border-bottom:1px solid var(--ink);padding-top:0;white-space:nowrap}
tbody tr+tr{border-top:1px solid var(--rule)}
td math{math-style:normal}p mfrac>*,li mfrac>*,td mfrac>*{math-depth:inherit}
td.num,.value,.together{white-space:nowrap}
td .error{display:block}
.value{font-variant-numeric:tabular-nums}
.error{color:var(--soft);font-size:.9em}
sup{font-size:.72em;line-height:0}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,21rem),1fr));
gap:1.1rem 2rem;margin:1.2rem 0 1.6rem;align-items:start}
figure{margin:0;min-width:0}
figure svg{display:block;width:100%;height:auto;max-width:34rem}
figcaption{font:.84rem/1.45 var(--sans);color:var(--soft);margin-top:.45rem}
figcaption math{font-size:1em}
.narrow{display:none}
@media (min-width:57rem){caption{white-space:nowrap}}
@media screen and (max-width:56rem){.wide{display:none}.narrow{display:block}
table.stack,table.stack tbody,table.stack tr,table.stack th,table.stack td,table.stack caption{display:block}
table.stack thead{display:none}table.stack tbody tr{padding:.45rem 0}table.stack td math{font-size:.88em}
table.stack td .error{display:inline}
table.stack th,table.stack td{padding:.1rem 0;overflow-wrap:anywhere;white-space:normal}
table.stack td::before{content:attr(data-label);
display:inline-block;min-width:7.2rem;padding-right:.6rem;font-size:.8rem;color:var(--soft)}
table.stack td:empty{display:none}}
@media (max-width:34rem){body{padding:1.5rem 1rem 3rem;font-size:1rem}td math{font-size:.9em}
.formula{padding-left:.3rem;flex-wrap:wrap;gap:.1rem}
.formula .scroll{flex-basis:100%}.tag{max-width:none;text-align:left}th,td{padding-right:.9rem}}
@media print{:root{--paper:#fff;--ink:#000;--soft:#444;--rule:#bbb;--blue:#1d4e7e;--red:#a3301c;
--wash:#f4f4f4;--green:#1f5a33;--amber:#6e4d00}
body{max-width:none;padding:0;font-size:10.5pt;line-height:1.42}nav{display:none}a{color:inherit;text-decoration:none}
h1{font-size:19pt}h2{break-after:avoid;margin-top:1.4rem;padding-top:.6rem}
figure,table,.formula,.note,.answer,.steps li{break-inside:avoid}
h2+p,h2+.formula,p:has(+.formula),p:has(+.scroll),p:has(+.figures),caption{break-after:avoid}
h2+p+.formula,h2+p+.scroll{break-before:avoid}.note{break-before:avoid}
p{orphans:3;widows:3;max-width:none;break-inside:avoid}table.long{break-inside:auto}tr{break-inside:avoid}
thead{break-after:avoid;display:table-header-group}
.formula{flex-wrap:wrap;margin:.4rem 0}.formula .scroll{min-width:min-content}
.formula>.tag:not(:last-child){order:0}
table{font-size:8.8pt;margin:.6rem 0 .9rem}th,td{padding-right:.7rem}
p math,li math{font-size:1.04em}td math{font-size:9.2pt}mfrac>*{math-depth:inherit}
.tag,caption,figcaption,thead th,.error{font-size:8pt}caption{white-space:nowrap}
.figures{grid-template-columns:1fr 1fr}.figures:has(>figure:only-child){grid-template-columns:min(100%,11.5cm)}
.scroll{overflow:visible}
@page{margin:17mm 16mm 19mm;
@bottom-center{content:counter(page) " / " counter(pages);font:8.5pt sans-serif;color:#444}}}
"""

LIGHT = (
    "--paper:#fff;--ink:#22262b;--soft:#666b72;--rule:#d9d5cc;--blue:#2f5f8f;--red:#b8402a;--wash:#f3f1ec;"
    "--green:#2e7044;--amber:#8a6100"
)
_DARK = (
    "--paper:#16191d;--ink:#e6e3dc;--soft:#a2a6ad;--rule:#3b4048;--blue:#7fb2e5;--red:#f0846b;--wash:#1f242a;"
    "--green:#7cc495;--amber:#e0b45c"
)
NOTEBOOK_CSS = (
    f".hjsolve{{{LIGHT};color:var(--ink);max-width:54rem;font:14px/1.5 system-ui,sans-serif}}"
    f"[data-jp-theme-light=false] .hjsolve,.vscode-dark .hjsolve,[theme=dark] .hjsolve,"
    f".body--dark .hjsolve{{{_DARK}}}"
    """
.hjsolve p{margin:.5em 0}
.hjsolve code{background:var(--wash);padding:.05em .3em;border-radius:3px}
.hjsolve table{border-collapse:collapse;margin:.6em 0;font-variant-numeric:tabular-nums}
.hjsolve caption{text-align:left;color:var(--soft);caption-side:top;padding:0 0 .3em;white-space:nowrap}
.hjsolve th,.hjsolve td{text-align:left!important;padding:.25em 1.1em .25em 0;font-weight:400;background:none;border:0}
.hjsolve thead th{color:var(--soft);border-bottom:1px solid var(--ink)}
.hjsolve tbody tr{background:none!important}
.hjsolve .narrow{display:none}
.hjsolve .scroll{overflow-x:auto;overflow-y:hidden;padding:.2em 0}
.hjsolve .value{white-space:nowrap}
.hjsolve td.num .error{display:block}
.hjsolve .formula{display:flex;align-items:center;gap:1em;margin:.4em 0;padding-left:1.2em}
.hjsolve .formula .scroll{flex:1 1 auto;min-width:0}
.hjsolve .tag,.hjsolve .error,.hjsolve figcaption,.hjsolve .note{color:var(--soft);font-size:.88em}
.hjsolve math{font-family:"Latin Modern Math","STIX Two Math","Cambria Math","Libertinus Math",
 "DejaVu Math TeX Gyre",math}
.hjsolve mtd{padding:.5ex .4em}
.hjsolve .lines>mtr>mtd{padding:.3em 0}
.hjsolve math[display=block]{margin:0;text-align:left;width:max-content}
.hjsolve .figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,20rem),1fr));gap:1em}
.hjsolve figure{margin:0}
.hjsolve figure svg{display:block;width:100%;max-width:34rem;height:auto}
"""
    f"{STYLE}"
)
"""Of a piece of a report in a notebook, whose own style it leaves alone."""
