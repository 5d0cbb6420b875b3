// The terms of use: words, and who runs the service.
import { showOperator } from "../lib/operator.js";
import { openPage } from "../lib/page.js";

openPage();
void showOperator({ name: "terms.name", contact: "terms.contact", imprint: "terms.imprint_name" });
