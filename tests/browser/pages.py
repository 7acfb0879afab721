"""A page in a browser, read and moved through the shadow trees of its parts."""

import json
import time
from contextlib import suppress

from selenium.common.exceptions import (
    ElementNotInteractableException,
    NoSuchElementException,
    StaleElementReferenceException,
)
from selenium.webdriver import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

_REPLACED = (ElementNotInteractableException, NoSuchElementException, StaleElementReferenceException)
"""What a part of the page raises that has just been replaced."""
_ALL = """
const found = []
const visit = (root) => {
  for (const element of root.querySelectorAll('*')) {
    if (element.matches(arguments[0])) found.push(element)
    if (element.shadowRoot) visit(element.shadowRoot)
  }
}
visit(document)
return found
"""


class Page:
    """The page of one browser."""

    def __init__(self, driver, address, folder):
        self.driver, self.folder = driver, folder
        driver.get(address)
        self.until(lambda: " ms" in self.status(), 120)

    def until(self, holds, seconds=30.0):
        """Wait for a state of the page; parts that are just replaced are read again."""
        end = time.monotonic() + seconds
        while True:
            with suppress(*_REPLACED, LookupError):
                if value := holds():
                    return value
            assert time.monotonic() < end, f"in vain for {seconds} s; the page says {self.status()!r}"
            time.sleep(0.2)  # a look walks through the whole page

    def all(self, selector):
        return self.driver.execute_script(_ALL, selector)

    def texts(self, selector):
        return self.driver.execute_script(
            f"return (function() {{ {_ALL} }}).apply(null, arguments).map((e) => e.textContent)", selector
        )

    def status(self):
        """What the case in front says: its status, or why it has none."""
        return (self.texts("div.case[role=status]") or [""])[0]

    def alerts(self):
        return [text for text in self.texts("[role=alert]") if text]

    def sliders(self):
        """The sliders that are seen, by name."""
        return dict(
            self.driver.execute_script(
                f"return (function() {{ {_ALL} }}).apply(null, arguments)"
                ".filter((e) => e.checkVisibility({visibilityProperty: true})).map((e) => [e.getAttribute('aria-label'), e])",
                "input[type=range]",
            )
        )

    def box(self, label):
        return self.driver.execute_script(_ALL, f'input[aria-label="{label}, value with unit"]')[0]

    def numbers(self):
        """Values by quantity of the first table."""
        return dict(
            self.driver.execute_script(
                f"const tables = (function() {{ {_ALL} }}).apply(null, arguments);"
                "return [...tables[0].querySelectorAll('tbody tr')].map((row) => [...row.children].slice(0, 2).map((e) => e.textContent))",
                "table.numbers",
            )
        )

    def press(self, element, key, times=1):
        element.send_keys(key * times)

    def move(self, label, key):
        """Press a key on a slider, which may just be drawn anew."""
        self.patiently(lambda: self.sliders()[label].send_keys(key))

    def patiently(self, act):
        """Act again while parts of the page are replaced."""
        for _ in range(50):
            try:
                return act()
            except (*_REPLACED, LookupError):
                time.sleep(0.1)
        return act()

    def enter(self, label, text, place=0):
        """Type a text in place of what is in a box."""
        box = self.driver.execute_script(_ALL, f'input[aria-label="{label}, value with unit"]')[place]
        self.driver.execute_script("arguments[0].focus(); arguments[0].select()", box)
        ActionChains(self.driver).send_keys(text, Keys.TAB).perform()

    def select(self, label, option):
        """Choose an option of a list by the words above it."""

        def choose():
            lists = [e for e in self.all("label") if e.text == label]
            inputs = lists[0].find_element(By.XPATH, "..").find_elements(By.TAG_NAME, "select")
            inputs[0].find_element(By.XPATH, f".//option[normalize-space()='{option}']").click()

        self.patiently(choose)

    def options(self, label):
        """The options of a list by the words above it."""

        def read():
            lists = [e for e in self.all("label") if e.text == label]
            return [
                o.text for o in lists[0].find_element(By.XPATH, "..").find_elements(By.TAG_NAME, "option")
            ]

        return self.patiently(read)

    def click(self, words):
        element = next(e for e in self.all("button, a, .bk-tab, label, span") if e.text.strip() == words)
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", element)
        element.click()

    def drop(self, name, content):
        """Drag a file of the computer onto the page."""
        file = self.folder / name
        file.write_bytes(content)
        data = {"items": [], "files": [str(file)], "dragOperationsMask": 1}
        for _ in range(3):  # the page may move below the pointer
            place = self.all(".filepond--root")[0]
            where = self.driver.execute_script(
                "arguments[0].scrollIntoView({block: 'center'}); const at = arguments[0].getBoundingClientRect();"
                "return {x: at.x + at.width / 2, y: at.y + at.height / 2}",
                place,
            )
            for kind in ("dragEnter", "dragOver", "drop"):
                self.driver.execute_cdp_cmd("Input.dispatchDragEvent", {"type": kind, **where, "data": data})
                time.sleep(0.2)
            for _ in range(40):
                if any(name in text for text in [*self.alerts(), *self.texts("div[role=status]")]):
                    return
                time.sleep(0.1)

    def downloaded(self, words, name):
        self.click(words)
        file = self.folder / name
        self.until(lambda: file.exists() and file.stat().st_size)
        return file

    def requests(self):
        """Addresses that the page asked for."""
        messages = (json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance"))
        return [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]

    def unnamed(self):
        """Controls without a name for screen readers."""
        self.driver.execute_cdp_cmd("Accessibility.enable", {})
        nodes = self.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
        controls = ("slider", "textbox", "combobox", "button", "checkbox", "spinbutton", "tab", "listbox")
        return [
            (node["role"]["value"], node.get("nodeId"))
            for node in nodes
            if not node.get("ignored")
            and node.get("role", {}).get("value") in controls
            and not node.get("name", {}).get("value")
        ]
