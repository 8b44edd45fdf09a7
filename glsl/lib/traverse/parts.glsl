// What a walk keeps between dispatches: WALK_WORDS words of `walks` for each invocation.
// Needs UPDATES(walks).

uint kept(uint word) {
    return walks[item_index() * WALK_WORDS + word];
}

void keep(uint word, uint value) {
    walks[item_index() * WALK_WORDS + word] = value;
}
