"""Pages in headless Chromium over its debugging pipe: see report_browser.sh."""
import base64
import json
import os
import subprocess
import sys
import tempfile

CONTRAST = r"""
(() => {
  const parse = c => { const m = c.match(/[\d.]+/g).map(Number); return m.length < 4 ? [...m, 1] : m; };
  const light = c => { const f = c.slice(0, 3).map(v => { v /= 255; return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; });
    return 0.2126 * f[0] + 0.7152 * f[1] + 0.0722 * f[2]; };
  let least = 99, at = '';
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const e = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || ['SCRIPT', 'STYLE', 'title'].includes(e.tagName)) continue;
    let ground = null;
    for (let p = e; p && !ground; p = p.parentElement) {
      const c = parse(getComputedStyle(p).backgroundColor);
      if (c[3] > 0.99) ground = c;
    }
    const style = getComputedStyle(e);
    const ink = parse(e instanceof SVGElement ? style.fill : style.color);
    const a = light(ink), b = light(ground || [255, 255, 255]);
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < least) { least = ratio; at = walker.currentNode.data.trim().slice(0, 30); }
  }
  return JSON.stringify([least.toFixed(2), at]);
})()
"""
SHIFT = """
new Promise(done => { let sum = 0;
  new PerformanceObserver(list => list.getEntries().forEach(e => { sum += e.value; }))
    .observe({ type: 'layout-shift', buffered: true });
  setTimeout(() => done(sum), 400); })
"""
DOME = "(document.querySelector('svg.dome circle') || {getAttribute: () => ''}).getAttribute('cx')"


class Browser:
    def __init__(self):
        self.profile = tempfile.TemporaryDirectory()
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def wire():
            os.dup2(to_browser, 103)
            os.dup2(from_browser, 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe",
             "--user-data-dir=" + self.profile.name, "about:blank"],
            preexec_fn=wire, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.rest, self.count, self.events, self.session = b"", 0, [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(domain + ".enable")

    def receive(self):
        while b"\0" not in self.rest:
            more = os.read(self.read_end, 1 << 16)
            if not more:
                raise RuntimeError("the browser has gone")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **params):
        self.count += 1
        message = {"id": self.count, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.write_end, data):]
        while True:
            answer = self.receive()
            if answer.get("id") == self.count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def ask(self, script):
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        return result["result"].get("value")

    def open(self, path, width, height, dark):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                  mobile=width < 500)
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.events.clear()
        self.call("Page.navigate", url="file://" + os.path.abspath(path))
        while not any(e.get("method") == "Page.loadEventFired" for e in self.events):
            self.events.append(self.receive())

    def picture(self, path):
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)["data"]
        with open(path, "wb") as f:
            f.write(base64.b64decode(data))

    def mouse(self, kind, x, y):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1,
                  buttons=1 if kind == "mouseMoved" else 0)

    def close(self):
        self.session = None
        try:
            self.call("Browser.close")
        except (RuntimeError, OSError):
            pass
        self.process.wait(timeout=10)
        self.profile.cleanup()


def complaints(browser):
    said, asked = [], []
    for e in browser.events:
        p = e.get("params", {})
        if e.get("method") in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"):
            said.append(json.dumps(p)[:120])
        if e.get("method") == "Network.requestWillBeSent":
            url = p["request"]["url"]
            if not url.startswith("data:"):
                asked.append(url)
    return said, asked


def turn(browser):
    """What the drawing of lights does when it is dragged, given a key, and clicked at."""
    if not browser.ask("!!document.querySelector('svg.dome')"):
        return "no drawing of lights"
    done = []
    browser.ask("document.querySelector('svg.dome').scrollIntoView({block: 'center'})")
    box = json.loads(browser.ask(
        "JSON.stringify(document.querySelector('svg.dome').getBoundingClientRect())"))
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = browser.ask(DOME)
    browser.mouse("mousePressed", x, y)
    browser.mouse("mouseMoved", x + 60, y + 20)
    browser.mouse("mouseReleased", x + 60, y + 20)
    dragged = browser.ask(DOME)
    done.append("dragging turns it" if dragged != before else "DRAGGING DOES NOTHING")
    browser.ask("document.querySelector('svg.dome').focus()")
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowLeft", code="ArrowLeft",
                 windowsVirtualKeyCode=37)
    done.append("keys turn it" if browser.ask(DOME) != dragged else "KEYS DO NOTHING")
    browser.ask("document.querySelector('[data-view=\"0,90\"]').scrollIntoView({block: 'center'})")
    box = json.loads(browser.ask(
        "JSON.stringify(document.querySelector('[data-view=\"0,90\"]').getBoundingClientRect())"))
    for kind in ("mousePressed", "mouseReleased"):
        browser.mouse(kind, box["x"] + 10, box["y"] + 10)
    turned = browser.ask("document.querySelector('svg.dome').dataset.turn")
    done.append("buttons turn it" if turned == "0,90" else f"BUTTON GAVE {turned}")
    browser.ask("document.querySelector('[data-view=\"\"]').click()")
    done.append("and back" if browser.ask(DOME) == before else "BUT NOT BACK")
    return ", ".join(done)


def main():
    out = sys.argv[1]
    os.makedirs(out, exist_ok=True)
    browser = Browser()
    try:
        for path in sys.argv[2:]:
            name = os.path.join(out, os.path.splitext(os.path.basename(path))[0])
            print(path)
            for width, dark, kind in ((1100, False, "desktop"), (1100, True, "dark"),
                                      (360, False, "phone"), (360, True, "phone-dark")):
                browser.open(path, width, 800, dark)
                said, asked = complaints(browser)
                wide = browser.ask("document.documentElement.scrollWidth")
                shift = browser.ask(SHIFT)
                least, at = json.loads(browser.ask(CONTRAST))
                browser.picture(f"{name}-{kind}.png")
                print(f"  {kind:<11} {len(said)} messages, {len(asked) - 1} requests beside the page, "
                      f"{wide} px wide of {width}, shift {shift:.3f}, least contrast {least} ('{at}')")
                for line in said + asked[1:]:
                    print("    ", line)
            browser.open(path, 1100, 800, False)
            print("  drawing    ", turn(browser))
            said, _ = complaints(browser)
            print(f"  afterwards  {len(said)} messages")
            browser.open(path, 720, 800, False)
            browser.call("Emulation.setEmulatedMedia", media="print")
            browser.picture(f"{name}-print.png")
            browser.call("Emulation.setEmulatedMedia", media="")
            data = browser.call("Page.printToPDF", printBackground=False, preferCSSPageSize=True)["data"]
            with open(f"{name}.pdf", "wb") as f:
                f.write(base64.b64decode(data))
    finally:
        browser.close()


if __name__ == "__main__":
    main()
